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
 * a null argument, also returns a status, in all builds. If a call fails, it does not change its
 * out-parameters.
 * Memory: the engine borrows an array from the call that adds or rebinds it. It stops using the
 * array when the client removes or rebinds the property or destroys the engine. The engine copies
 * the strings and structs that it receives. A returned `const char*` is static, or lives as long as
 * the engine or library that it describes.
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

/** The answer of the client's own provider about one property. The engine borrows the arrays until
 *  the next answer about the same property. They have the form described at
 *  `vesper_provider_add_physical_property`. */
typedef struct vesper_provided_property {
  uint32_t struct_size;
  uint32_t reserved;
  void* data;              /**< (value_count x components). */
  uint64_t value_count;    /**< Number of values in `data`. */
  const uint32_t* indices; /**< (object_count), or null: row i is value i. */
  uint64_t object_count;   /**< Number of rows of the kind. */
  uint64_t version;        /**< The client increases it after it edited values in place; see
                              `vesper_provider_touch`. */
  vesper_field field;      /**< For a FIELD property, instead of arrays. */
} vesper_provided_property;

/** A property provider that the client implements. The engine calls its functions between steps,
 *  on the thread that calls the engine. They must not call the engine and must not throw. */
typedef struct vesper_provider_callbacks {
  uint32_t struct_size;
  uint32_t reserved;
  void* user; /**< First argument of each callback. */
  /** Fills `out`, which the engine has zeroed except struct_size, with the named property. Returns
   *  NOT_FOUND if the client has no such property. With any other error, the engine call that
   *  needed the property fails and returns the message of the provider. */
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
  /** Selects how DEFERRED writes reach the arrays. A law that writes DEFERRED keeps the values
   *  elsewhere, for example on a GPU, until another law or the client needs them (see law.h).
   *  0: `advance` synchronizes all arrays before it returns and reads them again at its next call,
   *  so the client can ignore deferred writes.
   *  1: `advance` leaves deferred arrays stale. The client calls `vesper_engine_synchronize` before
   *  it reads, copies, moves or edits an array, and touches each array that it edited. Since
   *  1.1. */
  uint32_t deferred;
  /** 1: the client calls `vesper_provider_touch` for every array that it edited. Laws may then keep
   *  data that they derived from the other arrays, such as copies on a device. `deferred` 1
   *  requires the same.
   *  0: the client may have edited any array between two calls. Since 1.1. */
  uint32_t touches;
  /** (threads), or null. One word for each thread, in which the engine writes the law that the
   *  thread is calling. A client can observe the words from another thread or process. A word is 0
   *  if the thread calls no law. Otherwise its upper 32 bits are the id of the library, and its
   *  lower 32 bits are 1 + the index of the law. Borrowed until destroy. Since 1.1. */
  uint64_t* running;
  /** 1: a law that writes a magnitude of 2^333 (1.7e100) or more to an f64 property fails as if it
   *  had written infinity. Without this limit, another law that computes with the value may
   *  overflow, and the engine would report the other law. Since 1.2. */
  uint32_t limit_values;
  /** 1: a law rests while a field that it reads (a FIELD property, not optional) is not bound. The
   *  engine then does not call the law, which contributes nothing, and writes a warning to the log.
   *  0: `advance` returns NOT_FOUND. Since 1.2. */
  uint32_t rest_without_fields;
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
  const vesper_property_use* uses;         /**< `use_count` elements. */
  const vesper_parameter_desc* parameters; /**< `parameter_count` elements. */
  uint64_t calls;                          /**< Calls of its `advance` since it was loaded. */
  uint64_t nanoseconds; /**< Wall-clock time [ns] in these calls and in `synchronize`. Concurrent
                             laws each count their full time. For display only; it must not
                             affect the world. */
  uint32_t claims;      /**< VESPER_CLAIM_… joined with |, or 0. Since 1.2. */
  uint32_t resting;     /**< 1: it is not called, because a field that it reads was not bound in the
                             last step; see `rest_without_fields`. Otherwise 0. Since 1.2. */
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
                            body in each step [kg*m/s]. The rounding error of `momentum` grows with
                            this sum. 0 for lines that belong to no law. Since 1.2. */
  double angular_impulse_size; /**< Sum of the magnitudes of the angular impulses about the origin
                                    that the law's forces and torques gave to each body in each
                                    stage [kg*m^2/s]. Since 1.2. */
} vesper_ledger_entry;

/** Ledger lines that belong to no law; see `vesper_engine_ledger`. */
#define VESPER_LEDGER_CLIENT 0u   /**< The property appliedForce, and edits by the client. */
#define VESPER_LEDGER_GROUND 1u   /**< Momentum that immovable bodies absorbed, negated. */
#define VESPER_LEDGER_UNLOADED 2u /**< Laws that have been unloaded. */
#define VESPER_LEDGER_TOTAL 3u    /**< Measured change of all bodies: the sum of all lines. */

/** One row of the layout table. It contains the size of a struct of the contract in this build, or
 *  the size and offset of one of its fields. */
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
 *  docs/properties-and-units.md describes the format. Returns NOT_FOUND if the file cannot be read.
 *  The messages of other errors contain file:line:column, what was found and what was expected. */
VESPER_API vesper_status vesper_prototype_load(const char* path, vesper_prototype** out,
                                               vesper_error* error) VESPER_NOEXCEPT;
/** Reads a prototype from text. `source` names the text in messages. */
VESPER_API vesper_status vesper_prototype_parse(const char* text, const char* source,
                                                vesper_prototype** out,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Frees the result of load or parse. Engines keep their own copies. Accepts null. */
VESPER_API void vesper_prototype_free(vesper_prototype* prototype) VESPER_NOEXCEPT;

/** Parses a unit such as "N/m", "kg*m^2/s^2", "km/h", "m^3/(kg*s^2)", "deg" or "1". The text is
 *  UTF-8. It consists of products and quotients of powers with integer exponents, evaluated from
 *  left to right. It may contain parentheses, the units and prefixes listed in
 *  docs/properties-and-units.md, and numbers above 0. The symbol of `out` is the text, or empty
 *  if the text is longer than 15 bytes. For a wrong text, returns INVALID_ARGUMENT with a message
 *  that contains the column, counted in bytes. */
VESPER_API vesper_status vesper_unit_parse(const char* text, vesper_unit* out,
                                           vesper_error* error) VESPER_NOEXCEPT;

/** Fills the first `size` bytes of `config` with defaults. `size` is sizeof *config in the
 *  client's build. Since 1.1. */
VESPER_API void vesper_engine_config_init_sized(vesper_engine_config* config,
                                                uint64_t size) VESPER_NOEXCEPT;
/** Fills the 48 bytes of the struct of version 1.0 with defaults. Only programs that were compiled
 *  with version 1.0 call this function. In source code, `vesper_engine_config_init(&config)` is the
 *  macro below, which passes the size. */
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

/** Makes the engine query the client for arrays, instead of using registered arrays. The engine
 *  queries every property of the prototype at the next load, advance, find or hash, and again
 *  whenever the callback `version` returns a different number. The engine copies the callbacks.
 *  Returns ALREADY_EXISTS while arrays are registered. While callbacks are set, the functions that
 *  add, rebind and remove arrays return ACCESS_CONFLICT. `callbacks` null: unbinds all properties,
 *  and arrays can be registered again. */
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
/** Replaces the array of a property after it grew, shrank or moved. The arguments are those of
 *  `vesper_provider_add_physical_property`. All properties of a kind must agree on `object_count`
 *  again before the next `advance`. */
VESPER_API vesper_status vesper_provider_rebind_physical_property(
    vesper_provider* provider, const char* name, void* data, uint64_t value_count,
    const uint32_t* indices, uint64_t object_count, vesper_error* error) VESPER_NOEXCEPT;
/** Registers or replaces the field of a FIELD property; the engine copies `field`.
 *  vesper_provider_remove_physical_property also removes a field. Returns TYPE_MISMATCH if the
 *  property is not a FIELD property. */
VESPER_API vesper_status vesper_provider_set_field(vesper_provider* provider, const char* name,
                                                   const vesper_field* field,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Unbinds a property. Returns ACCESS_CONFLICT while a loaded law needs it. */
VESPER_API vesper_status vesper_provider_remove_physical_property(
    vesper_provider* provider, const char* name, vesper_error* error) VESPER_NOEXCEPT;
/** Fills `out` with the property as it is bound. The caller sets struct_size of `out` first. */
VESPER_API vesper_status
vesper_provider_find_physical_property(const vesper_provider* provider, const char* name,
                                       vesper_property* out, vesper_error* error) VESPER_NOEXCEPT;
/** Marks the values of the named properties as edited in place; `names` null: all properties. The
 *  engine then increases the versions of the properties, checks references again and expands
 *  indexed values again. Laws rebuild their caches. The call is not needed for values that laws
 *  read in each step, unless the property is a reference or indexed, or `config.deferred` is 1. */
VESPER_API vesper_status vesper_provider_touch(vesper_provider* provider, const char* const* names,
                                               uint32_t count, vesper_error* error) VESPER_NOEXCEPT;

/** Opens a law library without an engine, on any thread. A name that contains '/' is a path. Any
 *  other name is searched in each folder of `config->law_path`: a name `x.law` as this file, a bare
 *  name `x` as `libvesper_law_x.so`, then as `x.law`. A file whose name ends in `.law` is a text,
 *  see docs/laws-as-text.md. Any other file must be a complete ELF file. It is copied to a private
 *  file named by its content. The copy is opened in a separate probe process, then in this process,
 *  and its tables are checked. */
VESPER_API vesper_status vesper_library_prepare(const vesper_engine_config* config,
                                                const char* library, vesper_prepared_library** out,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Opens a law library from its bytes, in the same way as vesper_library_prepare. The bytes are
 *  copied. `source` names the library in messages. Bytes that are not a shared object are read as a
 *  text, as in vesper_library_prepare_text, unless `source` ends with `.so`. Since 1.1. */
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
/** Makes a prepared library from a table that another part of the program has built, for example
 *  from a file in another language. `table` is copied at once. The data that it points to must live
 *  until the engine calls `release(user)`, which happens when the library is unloaded or discarded.
 *  `release` may be null, and is not called if this function fails. Since 1.2. */
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
/** Checks a text against a prototype and writes all problems, with the lines concerned, to
 *  `report` (capacity). The report is NUL-terminated and truncated to `capacity` bytes. It is empty
 *  if the text has no problem. Since 1.2. */
VESPER_API vesper_status vesper_text_check(const vesper_prototype* prototype, const char* source,
                                           const char* text, uint64_t size, char* report,
                                           uint64_t capacity, vesper_error* error) VESPER_NOEXCEPT;
/** Translates a text to the C++ source of a law library that gives the same results. Writes the
 *  source, NUL-terminated, to `cpp` (capacity bytes), and its length without the NUL to `length`.
 *  `prototype` and `source` have the same meaning as for vesper_text_check. For a wrong text, fails
 *  with LIBRARY_LOAD_FAILED and the first problem. If the source needs more than `capacity` bytes,
 *  writes `length` and fails with INVALID_ARGUMENT. Since 1.2. */
VESPER_API vesper_status vesper_text_to_cpp(const vesper_prototype* prototype, const char* source,
                                            const char* text, uint64_t size, char* cpp,
                                            uint64_t capacity, uint64_t* length,
                                            vesper_error* error) VESPER_NOEXCEPT;
/** Closes a prepared library that was not loaded into an engine. Accepts null. */
VESPER_API void vesper_library_discard(vesper_prepared_library* prepared) VESPER_NOEXCEPT;
/** Returns the name in the library's own table. The string lives as long as `prepared` or the
 *  library loaded from it. */
VESPER_API const char* vesper_library_name(const vesper_prepared_library* prepared) VESPER_NOEXCEPT;

/** Activates a prepared library between two frames, without delay. Takes ownership of `prepared` on
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
/** Replaces a loaded library by a prepared library, between two frames and without delay. The new
 *  library takes the id and the place in the load order of the old library. Its interval is 1, and
 *  parameters that are not given have their defaults. A SCRATCH use keeps its values if the old law
 *  of the same name had a use of the same name, kind, type and number of components. Other SCRATCH
 *  uses begin with zeros. The new laws are checked against all libraries except the old one. If a
 *  new law is refused or cannot be created, nothing has changed and the caller still owns
 *  `prepared`. Errors: NOT_FOUND if the library is not loaded; ALREADY_EXISTS if another library
 *  has the name; FAULTED after a failed step. Since 1.2. */
VESPER_API vesper_status vesper_engine_replace_library(
    vesper_engine* engine, vesper_library_id library, vesper_prepared_library* prepared,
    const vesper_parameter* parameters, uint32_t count, vesper_error* error) VESPER_NOEXCEPT;
/** Begins a series of changes, such as loading and unloading, that can be undone as a whole. Until
 *  vesper_engine_end_changes, the engine keeps the libraries that are unloaded, without calling
 *  their laws. Call it between frames. Errors: ALREADY_EXISTS if a series has begun; FAULTED after
 *  a failed step. Since 1.2. */
VESPER_API vesper_status vesper_engine_begin_changes(vesper_engine* engine,
                                                     vesper_error* error) VESPER_NOEXCEPT;
/** Ends a series of changes. `keep` 1: frees the libraries that were unloaded. `keep` 0: restores
 *  the state of the engine at vesper_engine_begin_changes: the libraries with their ids, order,
 *  parameters and intervals, the step count, the time and the SCRATCH values. It opens no library
 *  and creates no law. The client restores its arrays. The contributions of an unloaded library to
 *  the ledger stay in the ledger's line `unloaded`. Returns NOT_FOUND if no series has begun. Since
 *  1.2. */
VESPER_API vesper_status vesper_engine_end_changes(vesper_engine* engine, uint32_t keep,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Sets the steps in which the laws of a library are called: every step whose number (see
 *  `vesper_engine_step_count`) is a multiple of `interval`. In these steps, the engine multiplies
 *  the contributions of the laws to accumulators by `interval`. In all other steps, the laws
 *  contribute nothing. Therefore their impulse over `interval` steps stays the same (the impulse
 *  method of r-RESPA). 1: the laws are called in every step; this is the default after loading.
 *  0: the laws are never called. More than 1 is refused with ACCESS_CONFLICT unless all laws of the
 *  library run in the phase FORCE and write no property. Any value except 1 is refused if a law of
 *  the library writes a DEFERRED use. Call it between frames, also while the engine is FAULTED.
 *  Since 1.2. */
VESPER_API vesper_status vesper_engine_set_interval(vesper_engine* engine,
                                                    vesper_library_id library, uint32_t interval,
                                                    vesper_error* error) VESPER_NOEXCEPT;
/** Fills `out` with law `index` of a loaded library, in the engine's precision. Returns NOT_FOUND
 *  past the last law. */
VESPER_API vesper_status vesper_engine_law_info(const vesper_engine* engine,
                                                vesper_library_id library, uint32_t index,
                                                vesper_law_info* out,
                                                vesper_error* error) VESPER_NOEXCEPT;

/** Copies the SCRATCH values of one row of a law to `out`, as doubles. `use` is an index of the
 *  uses that `vesper_engine_law_info` returns, and `count` is its number of components. A row that
 *  has no values yet is zero. Returns NOT_FOUND if the use does not exist or is no SCRATCH use, and
 *  INVALID_ARGUMENT for another `count`. Call it between frames. Since 1.2. */
VESPER_API vesper_status vesper_engine_scratch_row(const vesper_engine* engine,
                                                   vesper_library_id library, uint32_t law,
                                                   uint32_t use, uint64_t row, double* out,
                                                   uint32_t count,
                                                   vesper_error* error) VESPER_NOEXCEPT;

/** Applies all laws for `steps` steps of `dt` [time unit]. Either all steps take effect, or none.
 *  If a step fails, the engine is FAULTED, its time is unchanged, and written arrays are undefined.
 *  Restore them and call `vesper_engine_clear_fault`, or unload the library named in `error`. The
 *  status for NaN or infinity shows the source: LAW_MISBEHAVED if a law wrote it, INVALID_ARGUMENT
 *  with property and row but no library if a law only read it.
 *  An error found before the first step is not a fault. Nothing was written, and the call can be
 *  repeated once the cause is removed. Such errors are:
 *  - a `dt` that is not finite or not above 0 (INVALID_ARGUMENT);
 *  - arrays that disagree on their number of rows (COUNT_MISMATCH);
 *  - arrays that share memory that laws may write (ACCESS_CONFLICT);
 *  - a reference out of range (INVALID_ARGUMENT);
 *  - a property that a law needs but that is not bound (NOT_FOUND);
 *  - a law that refuses its arrays (LAW_FAILED);
 *  - a failure of the client's provider. */
VESPER_API vesper_status vesper_engine_advance(vesper_engine* engine, double dt, uint32_t steps,
                                               vesper_error* error) VESPER_NOEXCEPT;
/** Clears the fault of a failed step. The client must have restored the arrays. */
VESPER_API vesper_status vesper_engine_clear_fault(vesper_engine* engine,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Writes deferred values back to the named arrays; `names` null: to all arrays. Has an effect only
 *  if `vesper_engine_config.deferred` is 1. The calls unload, find, state_hash and save_state
 *  synchronize the arrays that they need; destroy does not. If the call fails, or a law writes
 *  values that are not finite, the engine is FAULTED as after a failed step. The step count still
 *  includes the steps, so the client must also load a saved state. If the client touches or rebinds
 *  an array, the content of the array is valid, and the engine discards the array's deferred
 *  values. */
VESPER_API vesper_status vesper_engine_synchronize(vesper_engine* engine, const char* const* names,
                                                   uint32_t count,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Announces that the item of row `from` of a kind moves to row `to` <= `from`, because the item of
 *  row `to` was removed. For example, the last row fills the gap of a removed item. The SCRATCH
 *  values of the laws move with the item, and those of row `from` are reset. `from == to`: the item
 *  of this row was removed. Call this function only if a row now belongs to another item. The
 *  engine itself detects rows that were added or removed at the end. */
VESPER_API vesper_status vesper_engine_move_row(vesper_engine* engine, const char* kind,
                                                uint64_t from, uint64_t to,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Returns in `out` the number of bytes that save_state would write now. The saved state contains
 *  the data that only the engine has: step count, time, and the SCRATCH values of laws. From the
 *  saved state and the client's arrays, a run continues with identical bits, also in another
 *  process on the same type of machine. */
VESPER_API vesper_status vesper_engine_state_size(vesper_engine* engine, uint64_t* out,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Writes the state to `out`, with a version and a checksum. `size` is the result of state_size,
 *  in bytes. */
VESPER_API vesper_status vesper_engine_save_state(vesper_engine* engine, void* out, uint64_t size,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Restores a saved state; the client restores the matching arrays. Returns INVALID_ARGUMENT if the
 *  state is damaged. Returns ACCESS_CONFLICT if it belongs to another prototype, or to other laws
 *  or law versions than the loaded ones; the message names them. If it fails, nothing changes. A
 *  fault remains until it is cleared. */
VESPER_API vesper_status vesper_engine_load_state(vesper_engine* engine, const void* state,
                                                  uint64_t size,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Removes the SCRATCH values of a library's laws from a saved state, in place. An engine without
 *  this library can then load the state. `*size` becomes the new size [bytes]. Returns
 *  INVALID_ARGUMENT if the state is damaged. Since 1.1. */
VESPER_API vesper_status vesper_saved_state_remove_library(void* state, uint64_t* size,
                                                           const char* library,
                                                           vesper_error* error) VESPER_NOEXCEPT;
/** Sets step count and time as if `steps` steps of `dt` [s] had been made from time 0. Use it if
 *  the arrays are the result of such a run but there is no saved state. SCRATCH values of laws are
 *  unchanged. Returns INVALID_ARGUMENT if `dt` is not finite or not above 0. */
VESPER_API vesper_status vesper_engine_set_step_count(vesper_engine* engine, uint64_t steps,
                                                      double dt,
                                                      vesper_error* error) VESPER_NOEXCEPT;
/** Returns the number of steps since create, including those from set_step_count or load_state. */
VESPER_API uint64_t vesper_engine_step_count(const vesper_engine* engine) VESPER_NOEXCEPT;

/** Computes a hash (XXH3-64) of the step count and the bound properties. The properties are in the
 *  order of the prototype, their rows in row order, and -0 counts as +0. For an indexed property,
 *  the expanded rows are hashed. */
VESPER_API vesper_status vesper_engine_state_hash(vesper_engine* engine, uint64_t* out,
                                                  vesper_error* error) VESPER_NOEXCEPT;

/** Switches the ledger on (1) or off (0). From the next advance on, the ledger records the
 *  momentum, angular momentum and energy that each law gives to the bodies. This costs a few passes
 *  over their columns in each step. Switching the ledger on again resets it. While it is off, it
 *  costs nothing. The ledger needs the properties mass, position and velocity of the standard
 *  prototypes, all of one kind. It also uses externalForce, torque, orientation, angularVelocity
 *  and inertia if they exist. Returns NOT_FOUND, TYPE_MISMATCH or UNIT_MISMATCH if the prototype
 *  lacks a needed property; the message names it. `advance` returns NOT_FOUND if mass, position or
 *  velocity is not bound. */
VESPER_API vesper_status vesper_engine_set_ledger(vesper_engine* engine, uint32_t on,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Fills `out` with the ledger line of a law of a loaded library, as of the last successful
 *  advance. `line` is the index of the law, or one of VESPER_LEDGER_… if `library` is
 *  VESPER_NO_LIBRARY. The caller sets struct_size first. Returns NOT_FOUND if the line does not
 *  exist or the ledger is off. Returns FAULTED after a failed step if the line includes potential
 *  energy. */
VESPER_API vesper_status vesper_engine_ledger(vesper_engine* engine, vesper_library_id library,
                                              uint32_t line, vesper_ledger_entry* out,
                                              vesper_error* error) VESPER_NOEXCEPT;
/** Computes the potential energy [J] of the forces of a law in the present state, whether the
 *  ledger is on or off. Returns NOT_FOUND if the law reports no potential energy. */
VESPER_API vesper_status vesper_engine_potential_energy(vesper_engine* engine,
                                                        vesper_library_id library, uint32_t law,
                                                        double* out,
                                                        vesper_error* error) VESPER_NOEXCEPT;

#ifdef __cplusplus
}
#endif
#endif /* VESPER_ENGINE_H_ */
