// SPDX-License-Identifier: Apache-2.0
/* The contract of a law library.
 *
 * A law library is a shared object that exports exactly one symbol, `vesper_law_library_entry`. It
 * may contain several laws (a suite) that share state, which `open` creates and `close` frees. A
 * law can access only the arrays that it declared, the step, and the host table (functions of the
 * engine). It keeps no evolving state of its own; evolving state belongs in properties. Private
 * memory may only cache what `create` and `bind` can rebuild. Therefore a law needs no code for
 * snapshots, rollbacks, replays and unloading at run time.
 *
 * If the engine has several threads, laws of different libraries run concurrently unless they
 * collide. Two laws collide if one of them writes a property that the other reads or writes. Two
 * laws that accumulate into the same property do not collide. Laws of one library never run
 * concurrently, so a suite needs no locks. For any number of threads, the results equal those of
 * sequential execution in load order.
 *
 * Rules for laws:
 * - A law starts no threads, uses no signals, and calls neither exit nor abort.
 * - A law lets no exception escape from its functions.
 * - A law restores the floating-point modes that it changes before a call returns.
 * - A law accesses only rows `[0, row_count)`.
 * - Equal inputs give equal bits. Therefore the order of summands must not depend on the number of
 *   threads.
 */
#ifndef VESPER_LAW_H_
#define VESPER_LAW_H_

#include "vesper/types.h"
#include "vesper/units.h"

#ifdef __cplusplus
extern "C" {
#endif

/** @{ */
/** Severity of a log line. */
#define VESPER_LOG_DEBUG 1u
#define VESPER_LOG_INFO 2u
#define VESPER_LOG_WARNING 3u
#define VESPER_LOG_ERROR 4u
/** @} */

/** Private data of a law, created by `create`. Opaque to the engine. */
typedef struct vesper_law vesper_law;
/** State that the laws of a library share, created by `open`. Opaque to the engine. */
typedef struct vesper_suite vesper_suite;

/** Functions that the engine provides to laws. Valid from `open` until `close` of the library. */
typedef struct vesper_host {
  uint32_t struct_size;
  uint32_t reserved;
  void* context; /**< First argument of each host function. */
  /** Writes one line to the engine's log. Call it on the thread that called the law, not within
   *  `parallel_for`. The client receives the lines of concurrent laws in load order, on its own
   *  thread. */
  void (*log)(void* context, uint32_t level, const char* message);
  /** Calls `body(user, begin, end)` for disjoint ranges that cover [0, count), possibly
   *  concurrently, and returns when all calls have returned. Ranges have `grain` elements (the
   *  last may have fewer) and do not depend on the number of threads; with `grain` 0 the engine
   *  chooses the length. `body` must not throw and must not call the host. */
  void (*parallel_for)(void* context, uint64_t count, uint64_t grain,
                       void (*body)(void* user, uint64_t begin, uint64_t end), void* user);
  const void* user; /**< `user` of the library's table (`vesper_law_library`). Since 1.2. */
} vesper_host;

/** One step, as passed to laws. Owned by the engine, valid during the call. */
typedef struct vesper_step {
  uint32_t struct_size;
  uint32_t stage;       /**< 0 in the call before the first force evaluation (integrators only),
                             then 1..stage_count. */
  uint32_t stage_count; /**< Number of force evaluations in this step. */
  uint32_t reserved;
  double dt;      /**< [time unit of the prototype], > 0. */
  double time;    /**< Time at the start of the step: the sum of all previous dt. Computed by
                       multiplication while dt is constant: index * dt if dt never changed. */
  uint64_t index; /**< Number of steps before this one. */
} vesper_step;

/** `vesper_property_use.flags`: the property may be absent; `bind` then receives null data and 0
 *  rows. */
#define VESPER_USE_OPTIONAL 1u

/** `vesper_property_use.flags`: the library keeps a copy of the property, for example on a
 *  device, and the law uses the copy. Since 1.1.
 *  READ: the law reads the copy, which may contain newer values than the array if an earlier law
 *  of the library wrote it.
 *  WRITE, READ_WRITE, ACCUMULATE: `advance` writes the copy only. From then on the array is
 *  stale. The engine calls `synchronize` to write the array before any other law or the client
 *  reads it. Only DEFERRED uses of the same library can access the copy.
 *  An accumulated copy also starts at zero. If other laws accumulate too, the engine calls
 *  `synchronize` at once, because it must sum the arrays.
 *  The library stores, with each copy, the version of the array from which the copy was made.
 *  Whenever the client or another library has written the array, the engine calls `bind` with a
 *  different `version` before the next `advance` or `potential_energy`. If `bind` passes a
 *  different version, the copy is stale and the array is valid; otherwise the copy is valid. */
#define VESPER_USE_DEFERRED 2u

/** `vesper_property_use.flags` of a FIELD: the law reads the slope of the field, too. Its function
 *  writes, for each component, the value and the derivatives of the value by x, y and z [unit/m]:
 *  (count x components x 4). The engine refuses the law while the field comes from a client, or
 * from a library that does not provide `slopes`. Since 1.2. */
#define VESPER_USE_SLOPE 4u

/** A property that a law uses. It is matched by name; kind, type, components and dimension must
 *  agree. If the unit of a real property differs in scale, the law receives a converted column
 *  of its own. The engine converts written values back; values that the law does not change keep
 *  their bits.
 *  For SCRATCH, only the kind must exist, and the law chooses the name. The values of a SCRATCH use
 *  belong to this law. They are committed or rolled back with the steps of an advance, and saved
 *  with the engine's state. */
typedef struct vesper_property_use {
  uint32_t struct_size;
  vesper_scalar_type scalar_type; /**< Element type. */
  const char* name;               /**< Name of the property. */
  const char* kind;               /**< Kind whose rows it has, e.g. "body". */
  uint32_t components;            /**< Components per row. */
  vesper_access access;           /**< Requested access, at most the prototype's `law_access`. */
  vesper_unit unit;               /**< Unit in which the law reads and writes. */
  uint32_t flags;                 /**< VESPER_USE_… joined with |, or 0. */
  uint32_t reserved;
} vesper_property_use;

/** A parameter of a law: a named double with unit and range, constant while the library is
 *  loaded. */
typedef struct vesper_parameter_desc {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name;     /**< Unique within the law. */
  const char* doc;      /**< One line. */
  vesper_unit unit;     /**< Unit of value and range. */
  double default_value; /**< Value if the client gives none. */
  double minimum;       /**< Inclusive. */
  double maximum;       /**< Inclusive. */
} vesper_parameter_desc;

/** `vesper_law_desc.claims`: invariants that the law guarantees; the law test kit checks them. */
#define VESPER_CLAIM_MOMENTUM 1u         /**< Sum of its forces on the bodies is zero. */
#define VESPER_CLAIM_ANGULAR_MOMENTUM 2u /**< Sum of its moments on the bodies is zero. */
#define VESPER_CLAIM_TRANSLATION 4u      /**< Invariant under a shift of the origin. */
#define VESPER_CLAIM_ROTATION 8u         /**< Forces rotate with the world. */
#define VESPER_CLAIM_ENERGY                                        \
  16u /**< The work of its forces is the decrease of its potential \
           energy. */

/** Describes one law in one precision. Static data of the library. */
typedef struct vesper_law_desc {
  uint32_t struct_size;
  vesper_scalar_type real_type;    /**< Real type of the prototype: VESPER_F32, VESPER_F64, or 0 for
                                        any. */
  const char* name;                /**< snake_case, unique within the library and precision. */
  const char* version;             /**< major.minor.patch */
  const char* doc;                 /**< One line. */
  vesper_phase phase;              /**< Phase of a step in which it runs. */
  uint32_t stages;                 /**< INTEGRATE: force evaluations per step, 1..16. Else 0. */
  uint32_t use_count;              /**< Length of `uses`. */
  uint32_t parameter_count;        /**< Length of `parameters`. */
  const vesper_property_use* uses; /**< `use_count` elements. */
  const vesper_parameter_desc* parameters; /**< `parameter_count` elements. */
  uint32_t claims;                         /**< VESPER_CLAIM_… joined with |, or 0. */
  uint32_t reserved;

  /** Creates the law. `parameters`: one value per declared parameter, in that order; the engine
   *  has checked the ranges. Called between frames. */
  vesper_status (*create)(const vesper_host* host, vesper_suite* suite, const double* parameters,
                          vesper_law** out, vesper_error* error);
  /** Passes the arrays to the law: one entry per declared use, in that order, borrowed until the
   *  next `bind` or `destroy`. Called before the first `advance` and again after each rebind or
   *  touch. */
  vesper_status (*bind)(vesper_law* law, const vesper_property* properties, vesper_error* error);
  /** Applies the law for one stage of one step. */
  vesper_status (*advance)(vesper_law* law, const vesper_step* step, vesper_error* error);
  /** Frees the law. `law` is never null. */
  void (*destroy)(vesper_law* law);
  /** Computes the potential energy [J] of this law's forces in the present state. The pointer is
   *  null if the forces have no potential. */
  vesper_status (*potential_energy)(vesper_law* law, double* out, vesper_error* error);
  /** Writes every row of the array of use `use` (index into `uses`), which is DEFERRED and was last
   *  written by this law. Called between calls of `advance`, on the client's thread. The engine
   *  checks the values for NaN and infinity as after `advance`. The pointer may be null if no
   *  written use is DEFERRED. Since 1.1. */
  vesper_status (*synchronize)(vesper_law* law, uint32_t use, vesper_error* error);
  /** For INTEGRATE laws: 1 + `stages` weights whose sum is 1, which the ledger uses. In a step, the
   *  velocity changes by dt / mass times the weighted sum of the forces. Weight [0] belongs to the
   *  forces at the end of the previous step, and each further weight to one stage. Null: weight [0]
   *  is 0, and all stages have equal weights. Since 1.1. */
  const double* force_weights;
  /** For INTEGRATE laws: the first stage for which the law is called, 0 or 1. Use 1 if the law
   *  has no work before the forces. Other laws use 0. Since 1.1. */
  uint32_t first_stage;
  uint32_t reserved1;
} vesper_law_desc;

/** A field that a library provides for a FIELD property of the prototype. Since 1.1. */
typedef struct vesper_field_desc {
  uint32_t struct_size;
  uint32_t components; /**< Components of each value. */
  const char* name;    /**< Name of the property. */
  const char* doc;     /**< One line. */
  vesper_unit unit;    /**< Unit of the values; converted if its scale differs from the
                            property's. */
  /** Evaluates the field as in `vesper_field`. The library fails, and not the law that reads the
   *  field, if the law fails after a value that is not finite. `user` is the suite of the library,
   *  or null if it has none. `advance` must not change data in `user` that this function reads,
   *  because other laws may evaluate the field concurrently. */
  void (*evaluate)(void* user, uint64_t count, const double* at, double* out);
  /** Receives the time of each step before the laws of the step run. It may store data in `user`
   *  that `evaluate` reads. Called on the client's thread while no law runs. Null: the field does
   *  not depend on the time. Since 1.2. */
  void (*begin_step)(void* user, const vesper_step* step);
  /** Describes why the field has no finite value at the position `at` (3) [m]: fills `message` and
   *  `law_index` of `error`. Called on a thread of the engine after a law that read this value
   *  failed. Null: the engine describes the value. Since 1.2. */
  void (*explain)(void* user, const double* at, vesper_error* error);
  /** Evaluates the field with its slope, for laws with the use VESPER_USE_SLOPE. Writes `out`
   *  (count x components x 4): for each component, the value and its derivatives by x, y and z
   *  [unit/m]. The same rules hold as for `evaluate`. Null: the slope is unknown. Since 1.2. */
  void (*slopes)(void* user, uint64_t count, const double* at, double* out);
} vesper_field_desc;

/** Description of a law library. Static data; the engine checks `abi_version` before it reads
 *  other fields. */
typedef struct vesper_law_library {
  uint32_t struct_size;
  uint32_t abi_version; /**< VESPER_ABI_VERSION of the headers it was built with. */
  const char* name;     /**< Name of the library, as in libvesper_law_NAME.so. */
  uint32_t law_count;   /**< Length of `laws`. */
  uint32_t reserved;
  const vesper_law_desc* laws; /**< `law_count` elements. */
  /** Creates the state that the library's laws share, once for each engine. Null if `close` is
   *  null. */
  vesper_status (*open)(const vesper_host* host, vesper_suite** out, vesper_error* error);
  /** Frees the state created by `open`, after the library's laws. Null if `open` is null. */
  void (*close)(vesper_suite* suite);
  /** Fields that are bound while the library is loaded. Since 1.1. */
  uint32_t field_count;
  uint32_t reserved1;
  const vesper_field_desc* fields; /**< `field_count` elements. */
  /** Passed to the laws as `vesper_host.user`; for tables that are created at run time, such as
   *  those of laws as text. Since 1.2. */
  const void* user;
} vesper_law_library;

/** The only exported symbol of a law library. The engine calls it once for each copy of the
 *  library that it maps, and copies the tables at that time. Later changes of the tables have no
 *  effect. The strings and functions to which the tables point must stay valid and unchanged. */
#define VESPER_LAW_LIBRARY_ENTRY "vesper_law_library_entry"
#if defined(__GNUC__)
/** Marks the symbol that a law library exports. */
#define VESPER_LAW_EXPORT __attribute__((visibility("default")))
#else
#define VESPER_LAW_EXPORT
#endif
/** Returns the description of the library. Defined by the library. */
VESPER_LAW_EXPORT const vesper_law_library* vesper_law_library_entry(void);

#ifdef __cplusplus
}
#endif
#endif /* VESPER_LAW_H_ */
