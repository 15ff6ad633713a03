// SPDX-License-Identifier: Apache-2.0
/* The C interface of the Vesper physics engine: what a client calls.
 *
 * The engine knows no physics. It holds named, typed, unit-checked property arrays that belong to
 * the client, and applies laws to them, each an independently compiled library.
 *
 * Threads: an engine is thread-compatible: one call at a time, from any thread; engines are
 * independent of each other. During `vesper_engine_advance` the arrays belong to the engine and
 * every other call on it returns VESPER_BUSY.
 * Errors: every fallible call returns a status and fills the optional `error`; misuse is a status,
 * in release too. Out-parameters are untouched on failure.
 * Memory: arrays are borrowed from add or rebind until remove, rebind or destroy. Strings and
 * structs passed in are copied. A returned `const char*` is static or lives as long as the engine
 * or library it describes.
 */
#ifndef VESPER_ENGINE_H_
#define VESPER_ENGINE_H_

#include "vesper/law.h"
#include "vesper/types.h"

#ifdef __cplusplus
#define VESPER_NOEXCEPT noexcept
extern "C" {
#else
#define VESPER_NOEXCEPT
#endif
#if defined(__GNUC__)
#define VESPER_API __attribute__((visibility("default")))
#else
#define VESPER_API
#endif

typedef struct vesper_engine vesper_engine;
typedef struct vesper_provider vesper_provider;
typedef struct vesper_prepared_library vesper_prepared_library;

/** What a client's own provider answers about one property: arrays as in
 *  `vesper_provider_add_physical_property`, borrowed until it answers otherwise. */
typedef struct vesper_provided_property {
  uint32_t struct_size;
  uint32_t reserved;
  void* data;
  uint64_t value_count;
  const uint32_t* indices;
  uint64_t object_count;
  uint64_t version;   /**< Another number after values were edited in place; see touch. */
  vesper_field field; /**< Instead of arrays, for a FIELD property. */
} vesper_provided_property;

/** A property provider of the client's own. Its functions are called between steps, on the thread
 *  that calls the engine; they must not call the engine and must not throw. */
typedef struct vesper_provider_callbacks {
  uint32_t struct_size;
  uint32_t reserved;
  void* user; /**< Handed back as first argument. */
  /** Fills `out` (zeroed, struct_size set) with the property of that name; NOT_FOUND if the client
   *  has none. Any other status fails the call of the engine that asked, with that message. */
  vesper_status (*find)(void* user, const char* name, vesper_provided_property* out,
                        vesper_error* error);
  /** Another number whenever `find` would answer otherwise; asked before every advance. */
  uint64_t (*version)(void* user);
} vesper_provider_callbacks;

/** How an engine is made. Start with `vesper_engine_config_init`. */
typedef struct vesper_engine_config {
  uint32_t struct_size;
  uint32_t threads;  /**< For laws that run at the same time, and for `parallel_for`; the
                          caller's included, idle ones sleep; default 1. */
  uint32_t validate; /**< 1: laws run on guarded copies and are held to their declaration. */
  uint32_t probe_timeout_ms; /**< For the throw-away probe of a library; default 5000. */
  const char* law_path;      /**< Folders searched for bare law names, separated by ':'. */
  const char* probe_path;    /**< The `vesper-probe` program; null: beside the engine library. */
  /** Receives log lines of engine and laws, on the calling thread; null: discarded. */
  void (*log)(void* user, uint32_t level, const char* message);
  void* log_user;
  /** What becomes of DEFERRED writes (see law.h). 0: `advance` synchronizes all arrays before it
   *  returns, and takes them as it finds them, so that a client need not know of any. 1: they stay
   *  where they are; the client calls `vesper_engine_synchronize` before it reads, copies, moves or
   *  edits an array, and touches what it edited. Since 1.1. */
  uint32_t deferred;
  /** 1: the client touches every array that it edited, so that what laws made of the others (copies
   *  on a device, springs in another order) still holds; `deferred` 1 asks for the same. 0: any
   *  array may have been edited between two calls. Since 1.1. */
  uint32_t touches;
} vesper_engine_config;

/** What is known about one loaded law. */
typedef struct vesper_law_info {
  uint32_t struct_size;
  vesper_library_id library_id;
  const char* library; /**< Name of its library. */
  const char* name;
  const char* version;
  const char* doc;
  vesper_phase phase;
  uint32_t stages;
  uint32_t use_count;
  uint32_t parameter_count;
  const vesper_property_use* uses;
  const vesper_parameter_desc* parameters;
  uint64_t calls;       /**< Of its `advance`, since it was loaded. */
  uint64_t nanoseconds; /**< Spent in these calls and in `synchronize`, wall clock, that of laws at
                             the same time counted for each; for people, never for the world. */
} vesper_law_info;

/** One line of the ledger, since it was switched on; see docs/ledger.md. In SI units, whatever the
 *  prototype's. Since 1.1. */
typedef struct vesper_ledger_entry {
  uint32_t struct_size;
  uint32_t has_potential_energy;   /**< 1: the two fields below say something; else they are 0. */
  double momentum[3];              /**< Given to bodies [kg*m/s]. */
  double angular_momentum[3];      /**< About the origin [kg*m^2/s]. */
  double energy;                   /**< Kinetic [J]: the work of a force law. */
  double initial_potential_energy; /**< [J], when the ledger first saw the law's arrays. */
  double potential_energy;         /**< [J], of the present state. */
} vesper_ledger_entry;

/** Lines of the ledger that are no law's; see `vesper_engine_ledger`. */
#define VESPER_LEDGER_CLIENT 0u   /**< appliedForce, and what the client changed between calls. */
#define VESPER_LEDGER_GROUND 1u   /**< What immovable bodies took, sign turned. */
#define VESPER_LEDGER_UNLOADED 2u /**< Laws that were unloaded since. */
#define VESPER_LEDGER_TOTAL 3u    /**< What all bodies gained, measured: the sum of all lines. */

/** One row of the layout table: how this build lays out the structs of the contract. */
typedef struct vesper_layout_entry {
  const char* struct_name; /**< e.g. "vesper_error" */
  const char* field;       /**< null: the row gives the struct's size. */
  uint32_t offset;
  uint32_t size;
} vesper_layout_entry;

VESPER_API uint32_t vesper_abi_version(void) VESPER_NOEXCEPT;
/** Compiler, flags and version of this build; static. */
VESPER_API const char* vesper_build_info(void) VESPER_NOEXCEPT;
/** "OK", "INVALID_ARGUMENT", …; "UNKNOWN" for a number that is no status. Static. */
VESPER_API const char* vesper_status_name(vesper_status status) VESPER_NOEXCEPT;
/** Sizes and offsets of all structs of the contract, for bindings to check theirs against. */
VESPER_API const vesper_layout_entry* vesper_abi_layout(uint32_t* count) VESPER_NOEXCEPT;

/** The standard prototypes, "si-f64" and "si-f32"; null for any other name. Static. */
VESPER_API const vesper_prototype* vesper_prototype_standard(const char* name) VESPER_NOEXCEPT;

/** Reads a prototype from a file; the caller frees `*out`. One line declares one property:
 *      body temperature: real x1 [K] read_write "Temperature of the whole body."
 *  docs/properties-and-units.md has the whole format. NOT_FOUND if the file cannot be read; what
 *  is wrong in it is named by file:line:column, found and expected. */
VESPER_API vesper_status vesper_prototype_load(const char* path, vesper_prototype** out,
                                               vesper_error* error) VESPER_NOEXCEPT;
/** The same from text; `source` names it in messages. */
VESPER_API vesper_status vesper_prototype_parse(const char* text, const char* source,
                                                vesper_prototype** out,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Frees what load or parse gave. Engines keep copies of their own. Null is fine. */
VESPER_API void vesper_prototype_free(vesper_prototype* prototype) VESPER_NOEXCEPT;

/** Reads a unit as people write it, e.g. "N/m", "kg*m^2/s^2", "km/h", "m^3/(kg*s^2)", "deg", "1".
 *  Products and quotients from left to right of powers with whole exponents; parentheses; SI units
 *  with prefixes f to P, and deg, min, h, d, L, t, bar, eV; numbers above 0. The symbol of `out` is
 *  the text, or empty if that is longer than 15 bytes. INVALID_ARGUMENT names the column. */
VESPER_API vesper_status vesper_unit_parse(const char* text, vesper_unit* out,
                                           vesper_error* error) VESPER_NOEXCEPT;

/** Fills the first `size` bytes, sizeof *config as the client was built, with defaults.
 *  Since 1.1. */
VESPER_API void vesper_engine_config_init_sized(vesper_engine_config* config,
                                                uint64_t size) VESPER_NOEXCEPT;
/** The same as a function without `size`, as clients built for 1.0 call it: it fills their 48
 *  bytes and no more. In source, `vesper_engine_config_init(&config)` is the macro, which knows
 *  the size. */
VESPER_API void vesper_engine_config_init(vesper_engine_config* config) VESPER_NOEXCEPT;
#define vesper_engine_config_init(config) \
  vesper_engine_config_init_sized((config), sizeof(*(config)))
VESPER_API vesper_status vesper_engine_create(const vesper_engine_config* config,
                                              const vesper_prototype* prototype,
                                              vesper_engine** out,
                                              vesper_error* error) VESPER_NOEXCEPT;
/** Unloads every law and frees the engine. Null is fine. */
VESPER_API void vesper_engine_destroy(vesper_engine* engine) VESPER_NOEXCEPT;

/** The engine's property provider; borrowed, lives as long as the engine. */
VESPER_API vesper_provider* vesper_engine_property_provider(vesper_engine* engine) VESPER_NOEXCEPT;

/** Lets the engine ask the client for arrays instead of having them registered: for every property
 *  of the prototype, at the next load, advance, find or hash, and again when `version` changes. The
 *  callbacks are copied. Refused with ALREADY_EXISTS while registered arrays are bound; add, rebind
 *  and remove are refused with ACCESS_CONFLICT from then on. `callbacks` null: nothing is bound,
 *  and arrays are registered again. */
VESPER_API vesper_status vesper_engine_set_property_provider(
    vesper_engine* engine, const vesper_provider_callbacks* callbacks,
    vesper_error* error) VESPER_NOEXCEPT;

/** Registers the client's array for a property of the prototype.
 *  data: (value_count x components) of the prototype's type. Without `indices` row i is value i and
 *  `value_count == object_count`. With `indices` (object_count), row i is value indices[i]; such a
 *  shared property is read-only to laws, and the engine expands it into a dense column. */
VESPER_API vesper_status vesper_provider_add_physical_property(
    vesper_provider* provider, const char* name, void* data, uint64_t value_count,
    const uint32_t* indices, uint64_t object_count, vesper_error* error) VESPER_NOEXCEPT;
/** Same arguments: the arrays grew, shrank or moved. All properties of a kind must agree on
 *  `object_count` again by the next `advance`. */
VESPER_API vesper_status vesper_provider_rebind_physical_property(
    vesper_provider* provider, const char* name, void* data, uint64_t value_count,
    const uint32_t* indices, uint64_t object_count, vesper_error* error) VESPER_NOEXCEPT;
/** Registers, or replaces, the field that stands for a FIELD property; it is copied. Remove it like
 *  arrays. TYPE_MISMATCH for any other property. */
VESPER_API vesper_status vesper_provider_set_field(vesper_provider* provider, const char* name,
                                                   const vesper_field* field,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Refused with ACCESS_CONFLICT while a loaded law needs the property. */
VESPER_API vesper_status vesper_provider_remove_physical_property(
    vesper_provider* provider, const char* name, vesper_error* error) VESPER_NOEXCEPT;
/** Fills `out` (whose struct_size the caller has set) with the property as it is bound. */
VESPER_API vesper_status
vesper_provider_find_physical_property(const vesper_provider* provider, const char* name,
                                       vesper_property* out, vesper_error* error) VESPER_NOEXCEPT;
/** Says that values were edited in place: raises versions, re-checks references, re-expands shared
 *  values, and lets laws rebuild what they cache. Not needed for what laws read afresh each step,
 *  unless the property is a reference or indexed, or `config.deferred` is 1. `names` null: all. */
VESPER_API vesper_status vesper_provider_touch(vesper_provider* provider, const char* const* names,
                                               uint32_t count, vesper_error* error) VESPER_NOEXCEPT;

/** Opens a law library without an engine, on any thread: finds it (a bare name `x` is searched as
 *  `libvesper_law_x.so` in `config->law_path`, anything with a '/' is used as is), checks that the
 *  ELF file is complete, copies it to a private file named by its content, opens the copy in a
 *  throw-away probe process, then here, and checks its tables. */
VESPER_API vesper_status vesper_library_prepare(const vesper_engine_config* config,
                                                const char* library, vesper_prepared_library** out,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** Closes a prepared library that no engine took. Null is fine. */
VESPER_API void vesper_library_discard(vesper_prepared_library* prepared) VESPER_NOEXCEPT;
/** Name in the library's own table; lives as long as `prepared`, or the library it became. */
VESPER_API const char* vesper_library_name(const vesper_prepared_library* prepared) VESPER_NOEXCEPT;

/** Activates a prepared library: instant, between frames. Takes `prepared` on success only. */
VESPER_API vesper_status vesper_engine_load_prepared(vesper_engine* engine,
                                                     vesper_prepared_library* prepared,
                                                     const vesper_parameter* parameters,
                                                     uint32_t count, vesper_library_id* out,
                                                     vesper_error* error) VESPER_NOEXCEPT;
/** Prepare and activate in one call. */
VESPER_API vesper_status vesper_engine_load_physics_law(vesper_engine* engine, const char* library,
                                                        const vesper_parameter* parameters,
                                                        uint32_t count, vesper_library_id* out,
                                                        vesper_error* error) VESPER_NOEXCEPT;
VESPER_API vesper_status vesper_engine_unload_physics_law(vesper_engine* engine,
                                                          vesper_library_id library,
                                                          vesper_error* error) VESPER_NOEXCEPT;
/** The i-th law of a loaded library (in the engine's precision); NOT_FOUND past the last. */
VESPER_API vesper_status vesper_engine_law_info(const vesper_engine* engine,
                                                vesper_library_id library, uint32_t index,
                                                vesper_law_info* out,
                                                vesper_error* error) VESPER_NOEXCEPT;

/** Applies all laws for `steps` steps of `dt` [time unit]: all steps count, or none. If a step
 *  fails, the engine is FAULTED, its time has not moved, and written arrays are undefined: restore
 *  them and call `vesper_engine_clear_fault`, or unload the library named in `error`. NaN or
 *  infinity is told from where it came: LAW_MISBEHAVED if a law wrote it, INVALID_ARGUMENT with
 *  property and row, and no library, if a law only read it.
 *  What is wrong before the first step is no fault: nothing was written, and another call is right
 *  as soon as the reason is gone. That is a bad `dt`, arrays that disagree on their rows
 *  (COUNT_MISMATCH) or share memory that laws may write (ACCESS_CONFLICT), a reference out of range
 *  (INVALID_ARGUMENT), a property that a law needs and nobody bound (NOT_FOUND), a law that refuses
 *  its arrays (LAW_FAILED), a provider of the client's that fails. */
VESPER_API vesper_status vesper_engine_advance(vesper_engine* engine, double dt, uint32_t steps,
                                               vesper_error* error) VESPER_NOEXCEPT;
VESPER_API vesper_status vesper_engine_clear_fault(vesper_engine* engine,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Makes arrays fresh whose newest values a law keeps elsewhere; `names` null: all. Nothing to do
 *  unless `vesper_engine_config.deferred` is 1. Unload, find, state_hash and save_state do it for
 *  what they concern; destroy does not. If it fails, or if what a law gives is not finite, the
 *  engine is FAULTED as after a failed step, but the steps stay counted: go back to a saved state.
 *  Arrays that the client touches or rebinds count as they are, whatever a law keeps. */
VESPER_API vesper_status vesper_engine_synchronize(vesper_engine* engine, const char* const* names,
                                                   uint32_t count,
                                                   vesper_error* error) VESPER_NOEXCEPT;
/** Says that the client moves row `from` of a kind to row `to` <= `from`, whose own item is
 *  gone, as when the last row fills the gap of one that was removed: what laws keep in SCRATCH
 *  moves along, and row `from` is as new. `from == to`: the item of that row is gone. Needed
 *  only where a row stands for another item than before; rows added or cut off at the end the
 *  engine sees itself. */
VESPER_API vesper_status vesper_engine_move_row(vesper_engine* engine, const char* kind,
                                                uint64_t from, uint64_t to,
                                                vesper_error* error) VESPER_NOEXCEPT;
/** What lives in the engine and in no array of the client: step count and time, and what laws keep
 *  in SCRATCH. Together with the arrays it continues a run to the bit, in this process or another
 *  of this machine's kind. `out`: bytes that save writes at present. */
VESPER_API vesper_status vesper_engine_state_size(vesper_engine* engine, uint64_t* out,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Writes the state to `out` (size bytes, as state_size said): versioned, with a checksum. */
VESPER_API vesper_status vesper_engine_save_state(vesper_engine* engine, void* out, uint64_t size,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Takes over a saved state; the arrays that belong to it the client restores. INVALID_ARGUMENT if
 *  it is damaged, ACCESS_CONFLICT if it is that of another prototype, or of other laws or versions
 *  than those loaded, which are named; then nothing is changed. A fault stays: clear it too. */
VESPER_API vesper_status vesper_engine_load_state(vesper_engine* engine, const void* state,
                                                  uint64_t size,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** Counts on as if `steps` steps of `dt` [s] had been done, from time 0: for arrays that come from
 *  such a run, without its saved state. What laws keep in SCRATCH stays. INVALID_ARGUMENT if `dt`
 *  is not finite or not above 0. */
VESPER_API vesper_status vesper_engine_set_step_count(vesper_engine* engine, uint64_t steps,
                                                      double dt,
                                                      vesper_error* error) VESPER_NOEXCEPT;
/** Steps done since create, those that were set or loaded included. */
VESPER_API uint64_t vesper_engine_step_count(const vesper_engine* engine) VESPER_NOEXCEPT;

/** XXH3-64 over the step count, then the bound properties in prototype order, rows in row order,
 *  -0 as +0. Indexed properties are hashed as rows, not as values. */
VESPER_API vesper_status vesper_engine_state_hash(vesper_engine* engine, uint64_t* out,
                                                  vesper_error* error) VESPER_NOEXCEPT;

/** Opens the ledger (1): from the next advance on the engine books how much momentum, angular
 *  momentum and energy each law gives to the bodies, which takes a few passes over their columns in
 *  each step. On again starts anew; off (0) costs nothing. It needs properties mass, position and
 *  velocity of the standard prototypes, of one kind, and knows externalForce, torque, orientation,
 *  angularVelocity and inertia where there are any: NOT_FOUND, TYPE_MISMATCH or UNIT_MISMATCH name
 *  what the prototype lacks. `advance` returns NOT_FOUND if the first three are not bound. */
VESPER_API vesper_status vesper_engine_set_ledger(vesper_engine* engine, uint32_t on,
                                                  vesper_error* error) VESPER_NOEXCEPT;
/** The line of a law of a loaded library, or, of VESPER_NO_LIBRARY, one of VESPER_LEDGER_…, as of
 *  the last advance that succeeded; the caller has set struct_size. NOT_FOUND if there is no such
 *  line or the ledger is off; FAULTED after a failed step where potential energy is asked for. */
VESPER_API vesper_status vesper_engine_ledger(vesper_engine* engine, vesper_library_id library,
                                              uint32_t line, vesper_ledger_entry* out,
                                              vesper_error* error) VESPER_NOEXCEPT;
/** Potential energy [J] of the present state that the law's forces derive from; ledger on or off.
 *  NOT_FOUND if the law reports none. */
VESPER_API vesper_status vesper_engine_potential_energy(vesper_engine* engine,
                                                        vesper_library_id library, uint32_t law,
                                                        double* out,
                                                        vesper_error* error) VESPER_NOEXCEPT;

#ifdef __cplusplus
}
#endif
#endif /* VESPER_ENGINE_H_ */
