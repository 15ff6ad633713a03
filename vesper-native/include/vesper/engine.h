// SPDX-License-Identifier: Apache-2.0
/* The C interface of the Vesper physics engine, for clients of the engine.
 *
 * The engine contains no physics. It holds named, typed property arrays with checked units. The
 * arrays belong to the client. Laws act on them, and each law library is compiled independently.
 *
 * Threads: an engine accepts one call at a time, from any thread. Engines are independent of each
 * other. During `vesper_engine_advance` the arrays belong to the engine, and every other call on
 * the same engine returns VESPER_BUSY.
 * Errors: every call that can fail returns a status and fills the optional `error`. Misuse, such as
 * a null argument, also returns a status, in release builds too. Out-parameters are unchanged on
 * failure. Memory: the engine borrows arrays from add or rebind until remove, rebind or destroy. It
 * copies strings and structs that it receives. A returned `const char*` is static, or lives as long
 * as the engine or library that it describes.
 */
#ifndef VESPER_ENGINE_H_
#define VESPER_ENGINE_H_

#include "vesper/law.h"
#include "vesper/types.h"

#ifdef __cplusplus
/** Declares that no exception leaves the engine. */
#define VESPER_NOEXCEPT noexcept
extern "C" {
#else
#define VESPER_NOEXCEPT
#endif
#if defined(__GNUC__)
/** Marks the exported functions of the engine's library. */
#define VESPER_API __attribute__((visibility("default")))
#else
#define VESPER_API
#endif

/** An engine, created by `vesper_engine_create`. */
typedef struct vesper_engine vesper_engine;
/** The arrays of the client that are registered with an engine. */
typedef struct vesper_provider vesper_provider;
/** A library that was opened and checked, but not yet loaded into an engine. */
typedef struct vesper_prepared_library vesper_prepared_library;

/** The answer of the client's own provider about one property: arrays as in
 *  `vesper_provider_add_physical_property`, borrowed until the next answer about the same property.
 *  */
typedef struct vesper_provided_property {
  uint32_t struct_size;
  uint32_t reserved;
  void* data;              /**< (value_count x components). */
  uint64_t value_count;    /**< Number of values in `data`. */
  const uint32_t* indices; /**< (object_count), or null: row i is value i. */
  uint64_t object_count;   /**< Number of rows of the kind. */
  uint64_t version;        /**< Increase it after values were edited in place; see
                              `vesper_provider_touch`. */
  vesper_field field;      /**< For a FIELD property, instead of arrays. */
} vesper_provided_property;

/** A property provider that the client implements. The engine calls its functions between steps,
 *  on the thread that calls the engine. They must not call the engine and must not throw. */
typedef struct vesper_provider_callbacks {
  uint32_t struct_size;
  uint32_t reserved;
  void* user; /**< First argument of each callback. */
  /** Fills `out` (zeroed, struct_size set) with the named property; returns NOT_FOUND if the
   *  client has no such property. Any other status fails the engine call that needed the
   *  property; that call returns the message of the provider. */
  vesper_status (*find)(void* user, const char* name, vesper_provided_property* out,
                        vesper_error* error);
  /** Returns a number that changes whenever the answer of `find` changes for any property. The
   *  engine calls it before every advance. */
  uint64_t (*version)(void* user);
} vesper_provider_callbacks;

/** Configuration of an engine. Initialise it with `vesper_engine_config_init`. */
typedef struct vesper_engine_config {
  uint32_t struct_size;
  uint32_t threads;  /**< Number of threads for concurrent laws and for `parallel_for`, including
                          the caller's thread. Idle threads sleep. Default 1. */
  uint32_t validate; /**< 1: laws run on guarded copies, and the engine checks them against their
                          declarations. */
  uint32_t probe_timeout_ms; /**< Timeout [ms] of the process that probes a library; default
                                  5000. */
  const char* law_path;      /**< Folders in which bare law names are searched, separated by ':'. */
  const char* probe_path;    /**< Path of the `vesper-probe` program; null: beside the engine
                                  library. Empty: no probe, for a client whose own process may crash
                                  without harm. */
  /** Receives log lines of engine and laws, on the calling thread. Null: lines are discarded. */
  void (*log)(void* user, uint32_t level, const char* message);
  void* log_user; /**< First argument of `log`. */
  /** Handling of DEFERRED writes: values that a law keeps elsewhere, for example on a GPU, until
   *  they are needed (see law.h). 0: `advance` synchronizes all arrays before it returns and reads
   *  them again at its next call, so the client can ignore deferred writes. 1: `advance` leaves
   *  deferred arrays stale. The client calls `vesper_engine_synchronize` before it reads, copies,
   *  moves or edits an array, and touches each array that it edited. Since 1.1. */
  uint32_t deferred;
  /** 1: the client touches every array that it edited, so laws may keep what they derived from
   *  the other arrays (copies on a device, reordered springs). `deferred` 1 requires the same.
   *  0: any array may have been edited between two calls. Since 1.1. */
  uint32_t touches;
  /** (threads), or null: where the engine writes which law each thread is calling, for a client
   *  that observes it from another thread or process. A word is 0, or the library's id in the
   *  upper and 1 + the law's index in the lower 32 bits. Borrowed until destroy. Since 1.1. */
  uint64_t* running;
  /** 1: a law that writes a magnitude of 2^333 (1.7e100) or more to an f64 property fails as if it
   *  had written infinity, so that it fails itself, and not the law that computes with the value.
   *  Since 1.2. */
  uint32_t limit_values;
  uint32_t reserved; /**< 0. */
} vesper_engine_config;

/** Information about one loaded law. */
typedef struct vesper_law_info {
  uint32_t struct_size;
  vesper_library_id library_id;            /**< Id of its library. */
  const char* library;                     /**< Name of its library. */
  const char* name;                        /**< Same as in `vesper_law_desc`, like all fields up to
                                              `parameters`. */
  const char* version;                     /**< major.minor.patch */
  const char* doc;                         /**< One line. */
  vesper_phase phase;                      /**< Phase of a step in which it runs. */
  uint32_t stages;                         /**< Stages of an integrator, else 0. */
  uint32_t use_count;                      /**< Length of `uses`. */
  uint32_t parameter_count;                /**< Length of `parameters`. */
  const vesper_property_use* uses;         /**< (use_count). */
  const vesper_parameter_desc* parameters; /**< (parameter_count). */
  uint64_t calls;                          /**< Calls of its `advance` since it was loaded. */
  uint64_t nanoseconds; /**< Wall-clock time [ns] in these calls and in `synchronize`. Concurrent
                             laws each count their full time. For display only; it must not
                             affect the world. */
  uint32_t claims;      /**< VESPER_CLAIM_… joined with |, or 0. Since 1.2. */
  uint32_t reserved;    /**< 0. */
} vesper_law_info;

/** One line of the ledger: the contribution of a law or another source since the ledger was
 *  switched on; see docs/ledger.md. Values are in SI units, whatever units the prototype has. Since
 *  1.1. */
typedef struct vesper_ledger_entry {
  uint32_t struct_size;
  uint32_t has_potential_energy;   /**< 1: the two potential-energy fields are valid. 0: both are
                                        0. */
  double momentum[3];              /**< Momentum given to bodies [kg*m/s]. */
  double angular_momentum[3];      /**< Angular momentum given to bodies, about the origin
                                        [kg*m^2/s]. */
  double energy;                   /**< Kinetic energy given to bodies [J]; for a force law, its
                                        work. */
  double initial_potential_energy; /**< [J], when the ledger first recorded this law. */
  double potential_energy;         /**< [J], in the present state. */
  double impulse_size; /**< Sum of the magnitudes of the impulses that the law's forces gave to each
                            body in each step [kg*m/s]; says how exact `momentum` can be. 0 for
                            lines that belong to no law. Since 1.2. */
  double angular_impulse_size; /**< Likewise of the moments about the origin, of forces and torques,
                                    in each stage [kg*m^2/s]. Since 1.2. */
} vesper_ledger_entry;

/** Ledger lines that belong to no law; see `vesper_engine_ledger`. */
#define VESPER_LEDGER_CLIENT 0u   /**< appliedForce, and changes by the client between calls. */
#define VESPER_LEDGER_GROUND 1u   /**< Momentum that immovable bodies absorbed, negated. */
#define VESPER_LEDGER_UNLOADED 2u /**< Laws that have been unloaded. */
#define VESPER_LEDGER_TOTAL 3u    /**< Measured change of all bodies: the sum of all lines. */

/** One row of the layout table: size of a struct of the contract in this build, or size and offset
 *  of one of its fields. */
typedef struct vesper_layout_entry {
  const char* struct_name; /**< e.g. "vesper_error" */
  const char* field;       /**< Null: the row gives the size of the struct. */
  uint32_t offset;         /**< [bytes] from the start of the struct; 0 for the struct itself. */
  uint32_t size;           /**< [bytes] of the field or the struct. */
} vesper_layout_entry;

/** Returns the VESPER_ABI_VERSION of the headers that the engine was built with. */
VESPER_API uint32_t vesper_abi_version(void) VESPER_NOEXCEPT;
/** Returns compiler, flags and version of this build; static. */
VESPER_API const char* vesper_build_info(void) VESPER_NOEXCEPT;
/** Returns "OK", "INVALID_ARGUMENT", …, or "UNKNOWN" for a number that is not a status. Static. */
VESPER_API const char* vesper_status_name(vesper_status status) VESPER_NOEXCEPT;
/** Returns sizes and offsets of all structs of the contract, so that bindings in other languages
 *  can check their own. */
VESPER_API const vesper_layout_entry* vesper_abi_layout(uint32_t* count) VESPER_NOEXCEPT;

/** Returns the standard prototype "si-f64" or "si-f32"; null for any other name. Static. */
VESPER_API const vesper_prototype* vesper_prototype_standard(const char* name) VESPER_NOEXCEPT;

/** Reads a prototype from a file; the caller frees `*out`. One line declares one property:
 *      body temperature: real x1 [K] read_write "Temperature of the whole body."
 *  docs/properties-and-units.md describes the format. NOT_FOUND if the file cannot be read; other
 *  messages contain file:line:column, what was found and what was expected. */
VESPER_API vesper_status vesper_prototype_load(const char* path, vesper_prototype** out,
                                               vesper_error* error) VESPER_NOEXCEPT;
/** Reads a prototype from text. `source` names the text in messages. */
VESPER_API vesper_status vesper_prototype_parse(const char* text, const char* source,
                                                vesper_prototype** out,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Frees the result of load or parse. Engines keep their own copies. Accepts null. */
VESPER_API void vesper_prototype_free(vesper_prototype* prototype) VESPER_NOEXCEPT;

/** Parses a unit such as "N/m", "kg*m^2/s^2", "km/h", "m^3/(kg*s^2)", "deg" or "1". The text is
 *  UTF-8: products and quotients, evaluated from left to right, of powers with integer
 *  exponents. It may contain parentheses, the units and prefixes listed in
 *  docs/properties-and-units.md, and numbers above 0. The symbol of `out` is the text, or empty
 *  if the text is longer than 15 bytes. INVALID_ARGUMENT names the column in bytes. */
VESPER_API vesper_status vesper_unit_parse(const char* text, vesper_unit* out,
                                           vesper_error* error) VESPER_NOEXCEPT;

/** Fills the first `size` bytes of `config` with defaults. `size` is sizeof *config in the
 *  client's build. Since 1.1. */
VESPER_API void vesper_engine_config_init_sized(vesper_engine_config* config,
                                                uint64_t size) VESPER_NOEXCEPT;
/** Fills the 48 bytes of the 1.0 struct with defaults; for programs that were compiled with version
 *  1.0. In source code, `vesper_engine_config_init(&config)` is the macro below, which passes the
 *  size. */
VESPER_API void vesper_engine_config_init(vesper_engine_config* config) VESPER_NOEXCEPT;
/** Fills `config` with defaults and passes the size of the client's struct. */
#define vesper_engine_config_init(config) \
  vesper_engine_config_init_sized((config), sizeof(*(config)))
/** Creates an engine for a prototype; both arguments are copied. The caller destroys `*out`. */
VESPER_API vesper_status vesper_engine_create(const vesper_engine_config* config,
                                              const vesper_prototype* prototype,
                                              vesper_engine** out,
                                              vesper_error* error) VESPER_NOEXCEPT;
/** Unloads every law and frees the engine. Accepts null. */
VESPER_API void vesper_engine_destroy(vesper_engine* engine) VESPER_NOEXCEPT;

/** Returns the property provider of the engine; borrowed, lives as long as the engine. */
VESPER_API vesper_provider* vesper_engine_property_provider(vesper_engine* engine) VESPER_NOEXCEPT;

/** Makes the engine query the client for arrays, instead of using registered ones. The engine
 *  queries every property of the prototype at the next load, advance, find or hash, and again
 *  whenever the callback `version` returns a different number. It copies the callbacks. Refused
 *  with ALREADY_EXISTS while arrays are registered; afterwards the functions that add, rebind and
 *  remove arrays are refused with ACCESS_CONFLICT. `callbacks` null: unbinds all properties, and
 *  arrays can be registered again. */
VESPER_API vesper_status vesper_engine_set_property_provider(
    vesper_engine* engine, const vesper_provider_callbacks* callbacks,
    vesper_error* error) VESPER_NOEXCEPT;

/** Registers the client's array for a property of the prototype.
 *  data: (value_count x components) of the prototype's type. Without `indices`, row i is value i
 *  and `value_count == object_count`. With `indices` (object_count), row i is value indices[i].
 *  Such a shared property is read-only to laws, and the engine expands it into a dense column. */
VESPER_API vesper_status vesper_provider_add_physical_property(
    vesper_provider* provider, const char* name, void* data, uint64_t value_count,
    const uint32_t* indices, uint64_t object_count, vesper_error* error) VESPER_NOEXCEPT;
/** Replaces the array of a property after it grew, shrank or moved; arguments as in add. All
 *  properties of a kind must agree on `object_count` again before the next `advance`. */
VESPER_API vesper_status vesper_provider_rebind_physical_property(
    vesper_provider* provider, const char* name, void* data, uint64_t value_count,
    const uint32_t* indices, uint64_t object_count, vesper_error* error) VESPER_NOEXCEPT;
/** Registers or replaces the field of a FIELD property; the engine copies `field`. Remove a
 *  field in the same way as arrays. TYPE_MISMATCH for any other property. */
VESPER_API vesper_status vesper_provider_set_field(vesper_provider* provider, const char* name,
                                                   const vesper_field* field,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Unbinds a property. Refused with ACCESS_CONFLICT while a loaded law needs it. */
VESPER_API vesper_status vesper_provider_remove_physical_property(
    vesper_provider* provider, const char* name, vesper_error* error) VESPER_NOEXCEPT;
/** Fills `out` with the property as it is bound. The caller sets struct_size of `out` first. */
VESPER_API vesper_status
vesper_provider_find_physical_property(const vesper_provider* provider, const char* name,
                                       vesper_property* out, vesper_error* error) VESPER_NOEXCEPT;
/** Marks values as edited in place: the engine increases the properties' versions, checks
 *  references again and expands indexed values again, and laws rebuild their caches. Not needed for
 *  values that laws read in each step, unless the property is a reference or indexed, or
 *  `config.deferred` is 1. `names` null: all properties. */
VESPER_API vesper_status vesper_provider_touch(vesper_provider* provider, const char* const* names,
                                               uint32_t count, vesper_error* error) VESPER_NOEXCEPT;

/** Opens a law library without an engine, on any thread. Searches a bare name `x` as
 *  `libvesper_law_x.so`, then as `x.law`, in each folder of `config->law_path`, and a name `x.law`
 *  as this file; uses a name that contains '/' as a path. A file whose name ends in `.law` is a
 *  text, see docs/laws-as-text.md. Otherwise
 *  checks that the ELF file is complete and copies it to a private file named by its content.
 *  Opens the copy in a separate probe process, then in this process, and checks its tables. */
VESPER_API vesper_status vesper_library_prepare(const vesper_engine_config* config,
                                                const char* library, vesper_prepared_library** out,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Opens a law library from its bytes, which are copied, in the same way. `source` names the
 *  library in messages. Unless it ends with `.so`, bytes that are not a shared object are read as a
 *  text, as in vesper_library_prepare_text. Since 1.1. */
VESPER_API vesper_status vesper_library_prepare_bytes(const vesper_engine_config* config,
                                                      const void* bytes, uint64_t size,
                                                      const char* source,
                                                      vesper_prepared_library** out,
                                                      vesper_error* error) VESPER_NOEXCEPT;
/** Opens a law library from a text of `size` bytes, on any thread; see docs/laws-as-text.md. A text
 *  cannot harm the process, so no probe process runs. `source` names the text in messages; null:
 *  "text". Checks only the syntax; names and units are checked when the library is loaded, because
 *  they depend on the prototype. Since 1.2. */
VESPER_API vesper_status vesper_library_prepare_text(const char* source, const char* text,
                                                     uint64_t size, vesper_prepared_library** out,
                                                     vesper_error* error) VESPER_NOEXCEPT;
/** Makes a prepared library of laws whose table another program part has built, for example from a
 *  file in another language. `table` is copied at once; the data that it points to must live until
 *  the library is unloaded or discarded, when `release(user)` is called. `release` may be null, and
 *  is not called if this function fails. Since 1.2. */
VESPER_API vesper_status vesper_library_prepare_table(const vesper_law_library* table,
                                                      void (*release)(void* user), void* user,
                                                      vesper_prepared_library** out,
                                                      vesper_error* error) VESPER_NOEXCEPT;
/** Returns in `out` the table of a prepared library. The table of a text depends on the prototype,
 *  and this call checks the text against it; other libraries ignore `prototype`. The table lives as
 *  long as `prepared`. Since 1.2. */
VESPER_API vesper_status vesper_library_table(vesper_prepared_library* prepared,
                                              const vesper_prototype* prototype,
                                              const vesper_law_library** out,
                                              vesper_error* error) VESPER_NOEXCEPT;
/** Checks a text against a prototype and writes all problems to `report` (capacity), with the lines
 *  concerned, NUL-terminated and truncated to `capacity` bytes. Empty if the text is right. Since
 *  1.2. */
VESPER_API vesper_status vesper_text_check(const vesper_prototype* prototype, const char* source,
                                           const char* text, uint64_t size, char* report,
                                           uint64_t capacity, vesper_error* error) VESPER_NOEXCEPT;
/** Writes a text as the C++ source of a law library that gives the same results, NUL-terminated, to
 *  `cpp` (capacity bytes), and its length without the NUL to `length`. `prototype` and `source` as
 *  for vesper_text_check. Fails with LIBRARY_LOAD_FAILED and the first problem of a wrong text;
 * with INVALID_ARGUMENT if the source needs more than `capacity` bytes, after `length` is written.
 *  Since 1.2. */
VESPER_API vesper_status vesper_text_to_cpp(const vesper_prototype* prototype, const char* source,
                                            const char* text, uint64_t size, char* cpp,
                                            uint64_t capacity, uint64_t* length,
                                            vesper_error* error) VESPER_NOEXCEPT;
/** Closes a prepared library that was not loaded into an engine. Accepts null. */
VESPER_API void vesper_library_discard(vesper_prepared_library* prepared) VESPER_NOEXCEPT;
/** Returns the name in the library's own table. The string lives as long as `prepared` or the
 *  library loaded from it. */
VESPER_API const char* vesper_library_name(const vesper_prepared_library* prepared) VESPER_NOEXCEPT;

/** Activates a prepared library between frames, without delay. Takes ownership of `prepared` on
 *  success only. */
VESPER_API vesper_status vesper_engine_load_prepared(vesper_engine* engine,
                                                     vesper_prepared_library* prepared,
                                                     const vesper_parameter* parameters,
                                                     uint32_t count, vesper_library_id* out,
                                                     vesper_error* error) VESPER_NOEXCEPT;
/** Prepares and activates a library in one call. */
VESPER_API vesper_status vesper_engine_load_physics_law(vesper_engine* engine, const char* library,
                                                        const vesper_parameter* parameters,
                                                        uint32_t count, vesper_library_id* out,
                                                        vesper_error* error) VESPER_NOEXCEPT;
/** Unloads a library's laws and closes the library, between frames, without delay. Clears a
 *  fault that its laws caused. */
VESPER_API vesper_status vesper_engine_unload_physics_law(vesper_engine* engine,
                                                          vesper_library_id library,
                                                          vesper_error* error) VESPER_NOEXCEPT;
/** Replaces a loaded library by a prepared one, between two frames and without delay. The new
 * library takes the id and the place of the old one; its interval is 1, and parameters that are not
 * given have their defaults. A SCRATCH use keeps its values if the law of the same name had a use
 * of the same name, kind, type and number of components; others begin with zeros. The new laws are
 *  checked against all libraries except the old one. If one is refused or cannot be created,
 *  nothing has changed and the caller still owns `prepared`. NOT_FOUND if the library is not
 *  loaded, ALREADY_EXISTS if another library has the name, FAULTED after a failed step. Since
 *  1.2. */
VESPER_API vesper_status vesper_engine_replace_library(
    vesper_engine* engine, vesper_library_id library, vesper_prepared_library* prepared,
    const vesper_parameter* parameters, uint32_t count, vesper_error* error) VESPER_NOEXCEPT;
/** Begins a series of changes, such as loading and unloading, that can be undone as a whole. Until
 *  vesper_engine_end_changes, the engine keeps the libraries that are unloaded, without calling
 *  their laws. Between frames. ALREADY_EXISTS if a series has begun; FAULTED after a failed step.
 *  Since 1.2. */
VESPER_API vesper_status vesper_engine_begin_changes(vesper_engine* engine,
                                                     vesper_error* error) VESPER_NOEXCEPT;
/** Ends a series of changes. `keep` 1: frees the libraries that were unloaded. 0: restores what
 *  vesper_engine_begin_changes found: the libraries with their ids, order, parameters and
 * intervals, step count, time and SCRATCH values. It opens no library and creates no law. The
 * client restores its arrays. The ledger keeps what an unloaded library had added in its line
 * `unloaded`. NOT_FOUND if no series has begun. Since 1.2. */
VESPER_API vesper_status vesper_engine_end_changes(vesper_engine* engine, uint32_t keep,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Sets in which steps the laws of a library are called: in those whose number (see
 *  `vesper_engine_step_count`) is a multiple of `interval`. In these steps, the engine multiplies
 *  what the laws add to accumulators by `interval`; in all others, they add nothing. So their
 *  impulse over `interval` steps stays the same (the impulse method of r-RESPA). 1: in every step,
 *  as after loading. 0: never. More than 1 is refused with ACCESS_CONFLICT unless all laws of the
 *  library run in the phase FORCE and write no property. Anything but 1 is refused if one of them
 *  writes a DEFERRED use. Between frames; also while the engine is FAULTED. Since 1.2. */
VESPER_API vesper_status vesper_engine_set_interval(vesper_engine* engine,
                                                    vesper_library_id library, uint32_t interval,
                                                    vesper_error* error) VESPER_NOEXCEPT;
/** Fills `out` with the i-th law of a loaded library, in the engine's precision. NOT_FOUND past
 *  the last law. */
VESPER_API vesper_status vesper_engine_law_info(const vesper_engine* engine,
                                                vesper_library_id library, uint32_t index,
                                                vesper_law_info* out,
                                                vesper_error* error) VESPER_NOEXCEPT;

/** Applies all laws for `steps` steps of `dt` [time unit]. Either all steps take effect, or none.
 *  If a step fails, the engine is FAULTED, its time is unchanged, and written arrays are undefined.
 *  Restore them and call `vesper_engine_clear_fault`, or unload the library named in `error`. The
 *  status for NaN or infinity shows the source: LAW_MISBEHAVED if a law wrote it, INVALID_ARGUMENT
 *  with property and row but no library if a law only read it. An error found before the first step
 *  is not a fault. Nothing was written, and the call can be repeated once the cause is removed.
 *  Such errors are a bad `dt`; arrays that disagree on their number of rows (COUNT_MISMATCH), or
 *  share memory that laws may write (ACCESS_CONFLICT); a reference out of range (INVALID_ARGUMENT);
 *  a property that a law needs but that is not bound (NOT_FOUND); a law that refuses its arrays
 *  (LAW_FAILED); a failure of the client's provider. */
VESPER_API vesper_status vesper_engine_advance(vesper_engine* engine, double dt, uint32_t steps,
                                               vesper_error* error) VESPER_NOEXCEPT;
/** Clears the fault of a failed step. The client must have restored the arrays. */
VESPER_API vesper_status vesper_engine_clear_fault(vesper_engine* engine,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Writes deferred values back to the named arrays; `names` null: to all arrays. Has an effect
 *  only if `vesper_engine_config.deferred` is 1. Unload, find, state_hash and save_state
 *  synchronize the arrays that they need; destroy does not. If the call fails, or a law delivers
 *  values that are not finite, the engine is FAULTED as after a failed step, but the steps stay
 *  counted: load a saved state. An array that the client touches or rebinds is valid as it is,
 *  and deferred values of it are discarded. */
VESPER_API vesper_status vesper_engine_synchronize(vesper_engine* engine, const char* const* names,
                                                   uint32_t count,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Call this when row `from` of a kind moves to row `to` <= `from`, whose item was removed, for
 *  example when the last row fills a gap. SCRATCH values of the laws move with the row, and row
 *  `from` is reset. `from == to`: the item of that row was removed. Call it only if a row now
 *  stands for another item; the engine detects rows that were added or removed at the end. */
VESPER_API vesper_status vesper_engine_move_row(vesper_engine* engine, const char* kind,
                                                uint64_t from, uint64_t to,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Returns in `out` the number of bytes that save_state would write now. The saved state
 *  contains what is in the engine and in no array of the client: step count, time, and the
 *  SCRATCH values of laws. Together with the arrays it continues a run with identical bits, in
 *  this process or another one on the same type of machine. */
VESPER_API vesper_status vesper_engine_state_size(vesper_engine* engine, uint64_t* out,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Writes the state to `out`, with a version and a checksum. `size` is the result of state_size,
 *  in bytes. */
VESPER_API vesper_status vesper_engine_save_state(vesper_engine* engine, void* out, uint64_t size,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Restores a saved state; the client restores the matching arrays. INVALID_ARGUMENT if the
 *  state is damaged. ACCESS_CONFLICT if it belongs to another prototype, or to other laws or law
 *  versions than the loaded ones; the message names them. On failure nothing changes. A fault
 *  remains until it is cleared. */
VESPER_API vesper_status vesper_engine_load_state(vesper_engine* engine, const void* state,
                                                  uint64_t size,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Removes the SCRATCH values of a library's laws from a saved state, in place, so that an engine
 *  without this library can load the state. `*size` becomes the new size [bytes]. INVALID_ARGUMENT
 *  if the state is damaged. Since 1.1. */
VESPER_API vesper_status vesper_saved_state_remove_library(void* state, uint64_t* size,
                                                           const char* library,
                                                           vesper_error* error) VESPER_NOEXCEPT;
/** Sets step count and time as if `steps` steps of `dt` [s] had been made from time 0. Use it if
 *  the arrays are the result of such a run but there is no saved state. SCRATCH values of laws are
 *  unchanged. INVALID_ARGUMENT if `dt` is not finite or not above 0. */
VESPER_API vesper_status vesper_engine_set_step_count(vesper_engine* engine, uint64_t steps,
                                                      double dt,
                                                      vesper_error* error) VESPER_NOEXCEPT;
/** Returns the number of steps since create, including those from set_step_count or load_state. */
VESPER_API uint64_t vesper_engine_step_count(const vesper_engine* engine) VESPER_NOEXCEPT;

/** Computes XXH3-64 over the step count and then the bound properties in prototype order, with rows
 *  in row order and -0 as +0. For an indexed property, the expanded rows are hashed. */
VESPER_API vesper_status vesper_engine_state_hash(vesper_engine* engine, uint64_t* out,
                                                  vesper_error* error) VESPER_NOEXCEPT;

/** Switches the ledger on (1) or off (0). From the next advance on, the ledger records the
 *  momentum, angular momentum and energy that each law gives to the bodies; this costs a few
 *  passes over their columns in each step. Switching it on again resets it; while it is off, it
 *  costs nothing. The ledger needs the properties mass, position and velocity of the standard
 *  prototypes, all of one kind. It also uses externalForce, torque, orientation, angularVelocity
 *  and inertia where they exist. NOT_FOUND, TYPE_MISMATCH or UNIT_MISMATCH name what the prototype
 *  lacks. `advance` returns NOT_FOUND if one of the first three is not bound. */
VESPER_API vesper_status vesper_engine_set_ledger(vesper_engine* engine, uint32_t on,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Fills `out` with the ledger line of a law of a loaded library, as of the last successful
 *  advance. If `library` is VESPER_NO_LIBRARY, `law` is one of VESPER_LEDGER_…. The caller sets
 *  struct_size first. NOT_FOUND if the line does not exist or the ledger is off; FAULTED after a
 *  failed step if the line includes potential energy. */
VESPER_API vesper_status vesper_engine_ledger(vesper_engine* engine, vesper_library_id library,
                                              uint32_t line, vesper_ledger_entry* out,
                                              vesper_error* error) VESPER_NOEXCEPT;
/** Computes the potential energy [J] of the forces of a law in the present state, whether the
 *  ledger is on or off. NOT_FOUND if the law reports none. */
VESPER_API vesper_status vesper_engine_potential_energy(vesper_engine* engine,
                                                        vesper_library_id library, uint32_t law,
                                                        double* out,
                                                        vesper_error* error) VESPER_NOEXCEPT;

#ifdef __cplusplus
}
#endif
#endif /* VESPER_ENGINE_H_ */
