// SPDX-License-Identifier: Apache-2.0
/* The contract of a law library.
 *
 * A law library is a shared object that exports exactly one symbol, `vesper_law_library_entry`.
 * It may hold several laws (a suite) that share state made by `open` and dropped by `close`. A law
 * sees only the arrays it declared, a step, and the host table; it keeps no state of its own that
 * evolves: what evolves is a property. Private memory may only cache what `create` and `bind` can
 * rebuild, so that snapshot, rollback, replay and hot unload need no code of the law.
 *
 * Laws of different libraries that do not collide (neither writes what the other reads or writes;
 * both may accumulate) run at the same time where the engine has threads; laws of one library never
 * do, so that a suite needs no locks. What comes out is the same as if they ran one after the other
 * in order of loading, whatever the number of threads.
 *
 * Rules of the house: no threads, no signals, no exit or abort, no exception across the boundary,
 * no change of floating-point modes that outlives a call. Rows `[0, row_count)` only. Same inputs,
 * same bits: sums in a fixed order, whatever the number of threads.
 */
#ifndef VESPER_LAW_H_
#define VESPER_LAW_H_

#include "vesper/types.h"
#include "vesper/units.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Severity of a log line. */
#define VESPER_LOG_DEBUG 1u
#define VESPER_LOG_INFO 2u
#define VESPER_LOG_WARNING 3u
#define VESPER_LOG_ERROR 4u

/** A law's private data, made by `create`; a suite's, made by `open`. Opaque to the engine. */
typedef struct vesper_law vesper_law;
typedef struct vesper_suite vesper_suite;

/** What the engine lends to laws. Valid from `open` until `close` of the library. */
typedef struct vesper_host {
  uint32_t struct_size;
  uint32_t reserved;
  void* context; /**< Hand back as first argument. */
  /** Writes one line to the engine's log: on the thread that called the law, not within
   *  `parallel_for`. The client receives lines in order of loading, on its own thread. */
  void (*log)(void* context, uint32_t level, const char* message);
  /** Calls `body(user, begin, end)` for disjoint ranges that cover [0, count), perhaps at the same
   *  time, and returns when all are done. Ranges are `grain` long (the last may be shorter) and do
   *  not depend on the number of threads; `grain` 0 lets the engine choose one. `body` must not
   *  throw and must not call back into the host. */
  void (*parallel_for)(void* context, uint64_t count, uint64_t grain,
                       void (*body)(void* user, uint64_t begin, uint64_t end), void* user);
} vesper_host;

/** One step, as laws see it. Owned by the engine, valid during the call. */
typedef struct vesper_step {
  uint32_t struct_size;
  uint32_t stage; /**< 0 before the first force evaluation (integrators), else 1..stage_count. */
  uint32_t stage_count; /**< Force evaluations in this step. */
  uint32_t reserved;
  double dt;      /**< [time unit of the prototype], > 0. */
  double time;    /**< At the beginning of the step: the sum of all dt before it. Multiplied, not
                       added up, while dt stays the same: index * dt if it always did. */
  uint64_t index; /**< Steps done before this one. */
} vesper_step;

/** `vesper_property_use.flags`: absent is fine; then `bind` sees null data and 0 rows. */
#define VESPER_USE_OPTIONAL 1u

/** `vesper_property_use.flags`: the library keeps a copy of the property, on a device say, and the
 *  law uses that. Since 1.1.
 *  READ: the law uses the copy, in which an earlier law of the library may have left newer values
 *  than the array has.
 *  WRITE, READ_WRITE, ACCUMULATE: `advance` writes the copy only. From then on the array is stale;
 *  the engine has it written by `synchronize` before any other law sees it, and before the client
 *  does. Only uses of the same library that are DEFERRED too see the copy. What is accumulated
 *  starts from zero in the copy as well; where other laws accumulate too, the engine has the array
 *  written at once, to sum it.
 *  When to take the array: `bind` is called before `advance` and `potential_energy` whenever
 *  somebody else wrote the array, and shows another `version` then. So a library keeps, with each
 *  copy, the version that it took it at; if `bind` shows another one, the copy is stale and the
 *  array is not; else the copy counts. */
#define VESPER_USE_DEFERRED 2u

/** A property that a law uses. Matched by name; kind, type, components and dimension must agree. If
 *  the unit of a real property differs in scale, the law sees a converted column of its own; what
 *  it writes is converted back, and values that it leaves alone keep their bits.
 *  SCRATCH is matched by kind alone and its name is the law's own: it belongs to this law, counts
 *  or is undone with the steps of an advance, and is saved with the engine's state. */
typedef struct vesper_property_use {
  uint32_t struct_size;
  vesper_scalar_type scalar_type;
  const char* name;
  const char* kind;
  uint32_t components;
  vesper_access access;
  vesper_unit unit;
  uint32_t flags;
  uint32_t reserved;
} vesper_property_use;

/** A parameter of a law: a named double with unit and range, fixed while the library is loaded. */
typedef struct vesper_parameter_desc {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name;
  const char* doc;
  vesper_unit unit;
  double default_value;
  double minimum; /**< Inclusive. */
  double maximum; /**< Inclusive. */
} vesper_parameter_desc;

/** `vesper_law_desc.claims`: what the law promises; the law test kit holds it to it. */
#define VESPER_CLAIM_MOMENTUM 1u         /**< Its forces on the bodies sum to zero. */
#define VESPER_CLAIM_ANGULAR_MOMENTUM 2u /**< Its moments on the bodies sum to zero. */
#define VESPER_CLAIM_TRANSLATION 4u      /**< Moving the origin changes nothing else. */
#define VESPER_CLAIM_ROTATION 8u         /**< Turning the world turns the forces. */

/** Describes one law in one precision. Static data of the library. */
typedef struct vesper_law_desc {
  uint32_t struct_size;
  vesper_scalar_type real_type; /**< Prototype it serves: VESPER_F32, VESPER_F64, or 0 for any. */
  const char* name;             /**< snake_case, unique within the library and precision. */
  const char* version;          /**< major.minor.patch */
  const char* doc;              /**< One line. */
  vesper_phase phase;
  uint32_t stages; /**< INTEGRATE: force evaluations per step, 1..16. Else 0. */
  uint32_t use_count;
  uint32_t parameter_count;
  const vesper_property_use* uses;
  const vesper_parameter_desc* parameters;
  uint32_t claims;
  uint32_t reserved;

  /** Makes the law. `parameters`: one value per declared parameter, in that order, range-checked
   *  by the engine. Called between frames. */
  vesper_status (*create)(const vesper_host* host, vesper_suite* suite, const double* parameters,
                          vesper_law** out, vesper_error* error);
  /** Hands over the arrays: one entry per declared use, in that order; borrowed until the
   *  next `bind` or `destroy`. Called before the first `advance` and again after each rebind
   *  or touch. */
  vesper_status (*bind)(vesper_law* law, const vesper_property* properties, vesper_error* error);
  /** Applies the law for one stage of one step. */
  vesper_status (*advance)(vesper_law* law, const vesper_step* step, vesper_error* error);
  /** Drops the law. Null is never passed. */
  void (*destroy)(vesper_law* law);
  /** Potential energy [J] of the present state that this law's forces derive from, or null if
   *  they derive from none. */
  vesper_status (*potential_energy)(vesper_law* law, double* out, vesper_error* error);
  /** Writes every row of the array of use `use`, its place in `uses`, which is DEFERRED and which
   *  this law was the last to write. Between calls of `advance`, on the thread of the client;
   *  checked for NaN and infinity like what `advance` writes. May be null where no written use is
   *  DEFERRED. Since 1.1. */
  vesper_status (*synchronize)(vesper_law* law, uint32_t use, vesper_error* error);
  /** Since 1.1. INTEGRATE, for the ledger: 1 + stages weights whose sum is 1, or null: 0, and the
   *  same for each stage. In a step the velocity changes by dt / mass times the weighted sum of the
   *  forces: [0] of those that the step before ended with, then of each stage's. */
  const double* force_weights;
  /** Since 1.1. INTEGRATE: the first stage that the law is called for, 0 or 1. 1: it has nothing to
   *  do before the forces, and is not asked. Else 0. */
  uint32_t first_stage;
  uint32_t reserved1;
} vesper_law_desc;

/** A field that a library brings for a FIELD property of the prototype. Since 1.1. */
typedef struct vesper_field_desc {
  uint32_t struct_size;
  uint32_t components;
  const char* name; /**< Of the property. */
  const char* doc;  /**< One line. */
  vesper_unit unit; /**< Of the values; converted if it differs from the property's in scale. */
  /** As in `vesper_field`; `user` is the library's suite, or null if it has none: what it reads
   *  there `advance` must not change, since other laws may evaluate it at the same time. */
  void (*evaluate)(void* user, uint64_t count, const double* at, double* out);
} vesper_field_desc;

/** What a law library is. Static data; the engine checks `abi_version` before it reads on. */
typedef struct vesper_law_library {
  uint32_t struct_size;
  uint32_t abi_version; /**< VESPER_ABI_VERSION it was built with. */
  const char* name;     /**< Name of the library, as in libvesper_law_NAME.so. */
  uint32_t law_count;
  uint32_t reserved;
  const vesper_law_desc* laws;
  /** Optional pair (both or none): state that the library's laws share, one per engine. */
  vesper_status (*open)(const vesper_host* host, vesper_suite** out, vesper_error* error);
  void (*close)(vesper_suite* suite);
  /** Since 1.1: fields that are bound while the library is loaded. */
  uint32_t field_count;
  uint32_t reserved1;
  const vesper_field_desc* fields;
} vesper_law_library;

/** The one exported symbol of a law library. The engine calls it once for each copy of the library
 *  that it maps, and copies the tables then: what it would answer, or the tables would say, at
 *  another time does not count. What they point to, names and functions, stays as it is. */
#define VESPER_LAW_LIBRARY_ENTRY "vesper_law_library_entry"
#if defined(__GNUC__)
#define VESPER_LAW_EXPORT __attribute__((visibility("default")))
#else
#define VESPER_LAW_EXPORT
#endif
VESPER_LAW_EXPORT const vesper_law_library* vesper_law_library_entry(void);

#ifdef __cplusplus
}
#endif
#endif /* VESPER_LAW_H_ */
