// SPDX-License-Identifier: Apache-2.0
/* Types that the engine, its clients and the laws share.
 *
 * The C layer is the binary contract between the parts. Its structs contain fixed-width integers
 * and no enum types, bools or bit fields. The engine exchanges structs with clients and laws. Such
 * a struct begins with `struct_size`, which the side that fills the struct sets. Minor versions
 * only append fields. Neither side reads or writes beyond the `struct_size` of the other; a missing
 * field counts as zero. A field that the engine does not know must be zero; otherwise the engine
 * returns ABI_MISMATCH. Therefore an engine accepts a law or client that was built for a later
 * minor version, if it uses no new feature. The stride of an array of such structs is the
 * `struct_size` of its first element. Fields named `reserved` are zero.
 *
 * These structs are frozen (never change) within a major version: `vesper_error`, `vesper_unit` and
 * `vesper_layout_entry`, which contain no size; `vesper_property`, which laws receive in arrays;
 * and `vesper_field`, which is part of other structs.
 */
#ifndef VESPER_TYPES_H_
#define VESPER_TYPES_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Version of this contract: laws and engine must have the same major version (see
 *  `vesper_law_library`). */
#define VESPER_ABI_MAJOR 1u
/** Increases when a field or function is appended. Laws and engines of different minor versions are
 *  compatible. */
#define VESPER_ABI_MINOR 2u
/** Major and minor version in one number, the major one in the upper 16 bits. */
#define VESPER_ABI_VERSION ((VESPER_ABI_MAJOR << 16) | VESPER_ABI_MINOR)

/** Result of a call. Numbers are never reused; `vesper_status_name` returns the name. */
typedef int32_t vesper_status;
#define VESPER_OK 0                   /**< Success. */
#define VESPER_INVALID_ARGUMENT 1     /**< An argument is null, out of range or not finite. */
#define VESPER_NOT_FOUND 2            /**< No property, law, library or prototype of that name. */
#define VESPER_ALREADY_EXISTS 3       /**< The name is taken. */
#define VESPER_BUSY 4                 /**< Another call on the engine is running. */
#define VESPER_ABI_MISMATCH 5         /**< Another contract version, or a newer feature is used. */
#define VESPER_TYPE_MISMATCH 6        /**< Scalar type or number of components differ. */
#define VESPER_UNIT_MISMATCH 7        /**< Units differ in dimension, or the type is not real. */
#define VESPER_COUNT_MISMATCH 8       /**< Properties of one kind have different row counts. */
#define VESPER_ACCESS_CONFLICT 9      /**< Access beyond the permitted one, or two laws collide. */
#define VESPER_LIBRARY_LOAD_FAILED 10 /**< The file is not a complete, loadable law library. */
#define VESPER_LAW_FAILED 11          /**< A law returned an error or threw. */
#define VESPER_LAW_MISBEHAVED 12      /**< A law broke its declaration, or wrote NaN or infinity. */
#define VESPER_FAULTED 13             /**< A step failed before; see `vesper_engine_clear_fault`. */
#define VESPER_INTERNAL 14            /**< A bug of the engine. Please report it. */
/* 15 is not used. */
#define VESPER_LAW_CRASHED 16   /**< A law that runs apart ended its process. Since 1.2. */
#define VESPER_LAW_TIMED_OUT 17 /**< A law that runs apart did not return in time. Since 1.2. */

/** Element type of a property. */
typedef uint32_t vesper_scalar_type;
#define VESPER_F32 1u   /**< IEEE 754 binary32. */
#define VESPER_F64 2u   /**< IEEE 754 binary64. */
#define VESPER_I32 3u   /**< Signed, 4 bytes. */
#define VESPER_U32 4u   /**< Unsigned, 4 bytes; also references to rows. */
#define VESPER_FIELD 5u /**< Not a column but a `vesper_field`. READ only; has a kind, no rows. */

/** Access of a law to a property, or, as a set of bits, the maximum access that laws may have. */
typedef uint32_t vesper_access;
#define VESPER_READ 1u       /**< The law only reads. */
#define VESPER_WRITE 2u      /**< The law writes every row before it returns, and reads none. */
#define VESPER_READ_WRITE 3u /**< The law reads, and may write any rows. */
#define VESPER_ACCUMULATE                                                 \
  4u /**< The law adds; the engine zeroes and sums over laws. FORCE only. \
      */
#define VESPER_SCRATCH                                                    \
  8u /**< Memory that the engine keeps for the law, not a property of the \
          client: `components` values for each row of the kind, initially \
          zero. The law reads and writes it in `advance` only. */

/** Phase of a step in which a law runs. Order of execution: phase, then load order. */
typedef uint32_t vesper_phase;
#define VESPER_PHASE_FORCE 1u     /**< Accumulates forces and torques. */
#define VESPER_PHASE_INTEGRATE 2u /**< Advances the state by dt. */
#define VESPER_PHASE_CONSTRAIN 3u /**< Corrects the advanced state. */
#define VESPER_PHASE_OBSERVE 4u   /**< Reads the result of the step. */

#define VESPER_NO_ROW UINT64_MAX /**< "No such row" in a `vesper_error`. */
#define VESPER_NO_LAW UINT32_MAX /**< "No such law" in a `vesper_error`. */
#define VESPER_NO_LIBRARY 0u     /**< "No such library" in a `vesper_error`. */

/** Identifies a loaded law library within one engine; starts at 1 and is never reused. */
typedef uint32_t vesper_library_id;

/** A physical unit: SI exponents and a scale. Frozen: 32 bytes.
 *  One unit = `scale` * m^e[0] * kg^e[1] * s^e[2] * A^e[3] * K^e[4] * mol^e[5] * cd^e[6].
 *  `symbol` is for messages only, NUL-terminated. Two units are equal if exponents and scale are
 *  equal. */
typedef struct vesper_unit {
  int8_t exponent[7]; /**< Exponents of m, kg, s, A, K, mol and cd. */
  uint8_t reserved;
  double scale;    /**< Scale of the unit in SI units; finite, above 0. */
  char symbol[16]; /**< NUL-terminated. */
} vesper_unit;

/** Description of a failure. The caller owns it and may pass null in every call. A call writes it
 *  only if the call fails. Frozen: 256 bytes. `message` is one line with the name of the object,
 *  what was found, and what was expected. */
typedef struct vesper_error {
  vesper_status status;         /**< The status that the call returned. */
  vesper_library_id library_id; /**< VESPER_NO_LIBRARY if no library caused it. */
  uint32_t law_index;           /**< Index within the library, or VESPER_NO_LAW. */
  uint32_t stage;               /**< Integrator stage of the step; 0 outside steps. */
  uint64_t row;                 /**< Row of `property`, or VESPER_NO_ROW. */
  char property[48];            /**< Empty if no property is involved. */
  char message[184];            /**< NUL-terminated. */
} vesper_error;

/** A named value that a law receives at load, in the unit that the law declares for it. */
typedef struct vesper_parameter {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name; /**< `parameter`, or `law.parameter` in a library of several laws. */
  double value;     /**< Value in the unit that the law declares. */
} vesper_parameter;

/** A function of position, such as wind or a magnetic field: the `data` of a bound FIELD
 *  property. Its numbers are always f64, whatever the real type of the prototype. */
typedef struct vesper_field {
  uint32_t struct_size;
  uint32_t reserved;
  void* user; /**< First argument of `evaluate`. */
  /** Writes values to `out` (count x components) [the property's unit] for the positions `at`
   *  (count x 3) [m]. Values must be finite and, within a step, depend on the position only.
   *  Several threads call it concurrently. */
  void (*evaluate)(void* user, uint64_t count, const double* at, double* out);
} vesper_field;

/** Declares one property of a prototype. Strings are copied when the engine is created. */
typedef struct vesper_property_descriptor {
  uint32_t struct_size;
  vesper_scalar_type scalar_type; /**< Element type. */
  const char* name;               /**< Unique within the prototype, at most 47 bytes. */
  const char* kind;    /**< E.g. "body". All properties of a kind have the same number of rows. */
  uint32_t components; /**< Components per row, at least 1. */
  vesper_access law_access; /**< Maximum access that a law may request. */
  vesper_unit unit;         /**< Unit of every component. */
  const char* refers_to;    /**< Kind whose rows this U32 column refers to, or null. */
  const char* initial_from; /**< For accumulators: a property of the same kind, type and unit. The
                                 sum of each stage starts from its values; null: from zero. */
  const char* doc;          /**< One line, may be null. */
  uint32_t has_minimum;     /**< 1: `minimum` is used. Only for reals that are no accumulators.
                                 Since 1.1. */
  uint32_t reserved;
  double minimum; /**< Minimum [unit] of every component. The engine checks the values that laws
                       write. It checks the arrays of READ properties at add, rebind and touch.
                       Since 1.1. */
} vesper_property_descriptor;

/** The set of properties that an engine is created for. The engine copies it at create; types and
 *  units never change after that. */
typedef struct vesper_prototype {
  uint32_t struct_size;
  vesper_scalar_type real_type; /**< VESPER_F32 or VESPER_F64; selects the variant of each law. */
  const char* name;             /**< Name for messages and saved states. */
  vesper_unit time_unit;        /**< Unit of `dt`. */
  uint32_t property_count;      /**< Length of `properties`. */
  uint32_t reserved;
  const vesper_property_descriptor* properties; /**< `property_count` elements. */
} vesper_prototype;

/** A bound property: data (rows x components), tightly packed, naturally aligned. */
typedef struct vesper_property {
  uint32_t struct_size;
  vesper_scalar_type scalar_type; /**< Element type of `data`. */
  const char* name;               /**< As in the prototype. */
  const char* kind;               /**< Kind whose rows it has. */
  uint32_t components;            /**< Components per row. */
  vesper_access access; /**< For a law: its declared access. From the provider: the maximum
                             access of any law. */
  void* data;           /**< May be null if `row_count` is 0 or the property is absent. For a
                             FIELD: its `const vesper_field*`. */
  uint64_t row_count;   /**< Number of rows of `data`. */
  uint64_t version;     /**< Increases when the client touches or rebinds the property; for a
                             DEFERRED use, also when another law writes the array. */
} vesper_property;

#ifdef __cplusplus
}
#endif
#endif /* VESPER_TYPES_H_ */
