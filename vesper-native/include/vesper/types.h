// SPDX-License-Identifier: Apache-2.0
/* Types that the engine, its clients and the laws share.
 *
 * The C layer is the contract: fixed-width integers, no enum types, no bools and no bit fields in
 * structs. Every struct that crosses the boundary begins with `struct_size`, set by whoever fills
 * the struct, and fields are only appended, in minor versions. Nobody reads or writes beyond the
 * `struct_size` of the other side: a field that is not there is zero. A field that the engine does
 * not know must be zero (ABI_MISMATCH), so that a law or client built for a later minor version
 * works as long as it asks for nothing new. Arrays of such structs are walked with the
 * `struct_size` of their first element as stride. Fields named `reserved` are zero.
 *
 * Frozen within a major version: `vesper_error`, `vesper_unit` and `vesper_layout_entry`, which do
 * not say their size; `vesper_property`, of which laws get arrays; and `vesper_field`, which is
 * part of other structs.
 */
#ifndef VESPER_TYPES_H_
#define VESPER_TYPES_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Version of this contract: laws and engine must share the major one (see
 *  `vesper_law_library`). */
#define VESPER_ABI_MAJOR 1u
#define VESPER_ABI_MINOR 1u
#define VESPER_ABI_VERSION ((VESPER_ABI_MAJOR << 16) | VESPER_ABI_MINOR)

/** Outcome of a call. Numbers are never reused; `vesper_status_name` gives the name. */
typedef int32_t vesper_status;
#define VESPER_OK 0                   /**< Done. */
#define VESPER_INVALID_ARGUMENT 1     /**< An argument is null, out of range or not finite. */
#define VESPER_NOT_FOUND 2            /**< No property, law, library or prototype of that name. */
#define VESPER_ALREADY_EXISTS 3       /**< The name is taken. */
#define VESPER_BUSY 4                 /**< The engine is inside `advance`. */
#define VESPER_ABI_MISMATCH 5         /**< Of another contract, or asks for more than this one. */
#define VESPER_TYPE_MISMATCH 6        /**< Scalar type or number of components differ. */
#define VESPER_UNIT_MISMATCH 7        /**< Units differ in dimension, or no real type. */
#define VESPER_COUNT_MISMATCH 8       /**< Properties of one kind have different row counts. */
#define VESPER_ACCESS_CONFLICT 9      /**< A law asks for more than allowed, or two laws collide. */
#define VESPER_LIBRARY_LOAD_FAILED 10 /**< The file is no complete, loadable law library. */
#define VESPER_LAW_FAILED 11          /**< A law returned an error or threw. */
#define VESPER_LAW_MISBEHAVED 12      /**< A law broke its declaration, or wrote NaN or infinity. */
#define VESPER_FAULTED 13             /**< A step failed before; see `vesper_engine_clear_fault`. */
#define VESPER_INTERNAL 14            /**< A bug of the engine. Please report it. */

/** Element type of a property. */
typedef uint32_t vesper_scalar_type;
#define VESPER_F32 1u
#define VESPER_F64 2u
#define VESPER_I32 3u
#define VESPER_U32 4u
#define VESPER_FIELD 5u /**< No column: a `vesper_field`. READ only; has a kind, but no rows. */

/** What a law does to a property, or (as a set of bits) the most that any law may do to it. */
typedef uint32_t vesper_access;
#define VESPER_READ 1u
#define VESPER_WRITE 2u /**< Every row is written before the law returns; not read. */
#define VESPER_READ_WRITE 3u
#define VESPER_ACCUMULATE                                                \
  4u /**< Added to; the engine zeroes it and sums over laws. FORCE only. \
      */
#define VESPER_SCRATCH                                                    \
  8u /**< No property of the client: memory that the engine keeps for the \
          law, `components` values for each row of the kind, zero at      \
          first. The law reads and writes it in `advance` only. */

/** When a law runs within a step. Order of execution: phase, then order of loading. */
typedef uint32_t vesper_phase;
#define VESPER_PHASE_FORCE 1u     /**< Accumulates forces and torques. */
#define VESPER_PHASE_INTEGRATE 2u /**< Moves the state by dt. */
#define VESPER_PHASE_CONSTRAIN 3u /**< Corrects the moved state. */
#define VESPER_PHASE_OBSERVE 4u   /**< Reads the result of the step. */

/** "No such row, law or library" in a `vesper_error`. */
#define VESPER_NO_ROW UINT64_MAX
#define VESPER_NO_LAW UINT32_MAX
#define VESPER_NO_LIBRARY 0u

/** Names a loaded law library within one engine; starts at 1, never reused. */
typedef uint32_t vesper_library_id;

/** A physical unit: SI exponents and a scale. Frozen: 32 bytes.
 *  One unit = `scale` * m^e[0] * kg^e[1] * s^e[2] * A^e[3] * K^e[4] * mol^e[5] * cd^e[6].
 *  `symbol` is for messages only, NUL-terminated; equality is exponents and scale. */
typedef struct vesper_unit {
  int8_t exponent[7];
  uint8_t reserved;
  double scale;
  char symbol[16];
} vesper_unit;

/** What went wrong. Caller-owned, optional (null) everywhere, written on failure only. Frozen:
 *  256 bytes. `message` is one line that names the thing, what was found, and what was expected. */
typedef struct vesper_error {
  vesper_status status;
  vesper_library_id library_id; /**< VESPER_NO_LIBRARY if no library is to blame. */
  uint32_t law_index;           /**< Within the library, or VESPER_NO_LAW. */
  uint32_t stage;               /**< Integrator stage of the step, 0 outside steps. */
  uint64_t row;                 /**< Row of `property`, or VESPER_NO_ROW. */
  char property[48];            /**< Empty if no property is concerned. */
  char message[184];
} vesper_error;

/** A named value handed to a law at load, in the unit that the law declares for it. */
typedef struct vesper_parameter {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name; /**< `parameter`, or `law.parameter` in a library of several laws. */
  double value;
} vesper_parameter;

/** A function of position, such as wind or a magnetic field; the `data` of a bound FIELD property.
 *  Always f64, whatever the prototype's real type. */
typedef struct vesper_field {
  uint32_t struct_size;
  uint32_t reserved;
  void* user; /**< Handed back as first argument. */
  /** out (count x components) [the property's unit] at the positions `at` (count x 3) [m]. Finite,
   *  a function of position only within a step; called from several threads at the same time. */
  void (*evaluate)(void* user, uint64_t count, const double* at, double* out);
} vesper_field;

/** Declares one property of a prototype. Strings are copied when the engine is created. */
typedef struct vesper_property_descriptor {
  uint32_t struct_size;
  vesper_scalar_type scalar_type;
  const char* name; /**< Unique within the prototype, at most 47 bytes. */
  const char* kind; /**< Row space: all properties of a kind have the same number of rows. */
  uint32_t components;
  vesper_access law_access; /**< The most that any law may ask for. */
  vesper_unit unit;
  const char* refers_to;    /**< Kind that this U32 column's values are rows of, or null. */
  const char* initial_from; /**< For accumulators: property of the same kind, type and unit that
                                 each stage's sum starts from instead of zero; null for zero. */
  const char* doc;          /**< One line, may be null. */
  uint32_t has_minimum;     /**< 1: `minimum` counts. Only for numbers that laws READ. Since 1.1. */
  uint32_t reserved;
  double minimum; /**< Least value [unit] of every component: the client's arrays are held to it
                       when they are added, rebound or touched. Since 1.1. */
} vesper_property_descriptor;

/** The contract of one use: which properties exist. The engine copies it at create; types and
 *  units never change after that. */
typedef struct vesper_prototype {
  uint32_t struct_size;
  vesper_scalar_type real_type; /**< VESPER_F32 or VESPER_F64: which variant of each law is used. */
  const char* name;
  vesper_unit time_unit; /**< Unit of `dt`. */
  uint32_t property_count;
  uint32_t reserved;
  const vesper_property_descriptor* properties;
} vesper_prototype;

/** A property as it is bound: data (rows x components), tightly packed, natural alignment. */
typedef struct vesper_property {
  uint32_t struct_size;
  vesper_scalar_type scalar_type;
  const char* name;
  const char* kind;
  uint32_t components;
  vesper_access access; /**< Of the law it is handed to; of any law (the most) from the provider. */
  void* data;           /**< May be null if `row_count` is 0 or the property is absent. Of a
                             FIELD: its `const vesper_field*`. */
  uint64_t row_count;
  uint64_t version; /**< Raised when the client touched or rebound the property; where the
                         use is DEFERRED, also when another law wrote the array. */
} vesper_property;

#ifdef __cplusplus
}
#endif
#endif /* VESPER_TYPES_H_ */
