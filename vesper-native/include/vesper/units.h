// SPDX-License-Identifier: Apache-2.0
/* Units of the standard prototypes, as constant initialisers of `vesper_unit`.
 *
 * The order of the exponents is metre, kilogram, second, ampere, kelvin, mole, candela. Angles are
 * numbers: the radian has the unit 1.
 */
#ifndef VESPER_UNITS_H_
#define VESPER_UNITS_H_

#include "vesper/types.h"

/** A `vesper_unit` from the exponents of m, kg, s, A, K, mol and cd, a scale and a symbol. */
#define VESPER_UNIT_INIT(m, kg, s, a, k, mol, cd, scale, symbol) \
  {{(m), (kg), (s), (a), (k), (mol), (cd)}, 0, (scale), symbol}

/** @{ */
/** A unit of the standard prototypes. */
#define VESPER_UNIT_ONE VESPER_UNIT_INIT(0, 0, 0, 0, 0, 0, 0, 1.0, "1")
#define VESPER_UNIT_METRE VESPER_UNIT_INIT(1, 0, 0, 0, 0, 0, 0, 1.0, "m")
#define VESPER_UNIT_KILOGRAM VESPER_UNIT_INIT(0, 1, 0, 0, 0, 0, 0, 1.0, "kg")
#define VESPER_UNIT_SECOND VESPER_UNIT_INIT(0, 0, 1, 0, 0, 0, 0, 1.0, "s")
#define VESPER_UNIT_KELVIN VESPER_UNIT_INIT(0, 0, 0, 0, 1, 0, 0, 1.0, "K")
#define VESPER_UNIT_COULOMB VESPER_UNIT_INIT(0, 0, 1, 1, 0, 0, 0, 1.0, "C")
#define VESPER_UNIT_METRE_PER_SECOND VESPER_UNIT_INIT(1, 0, -1, 0, 0, 0, 0, 1.0, "m/s")
#define VESPER_UNIT_METRE_PER_SECOND_SQUARED VESPER_UNIT_INIT(1, 0, -2, 0, 0, 0, 0, 1.0, "m/s^2")
#define VESPER_UNIT_RADIAN_PER_SECOND VESPER_UNIT_INIT(0, 0, -1, 0, 0, 0, 0, 1.0, "rad/s")
#define VESPER_UNIT_NEWTON VESPER_UNIT_INIT(1, 1, -2, 0, 0, 0, 0, 1.0, "N")
#define VESPER_UNIT_NEWTON_METRE VESPER_UNIT_INIT(2, 1, -2, 0, 0, 0, 0, 1.0, "N*m")
#define VESPER_UNIT_NEWTON_PER_METRE VESPER_UNIT_INIT(0, 1, -2, 0, 0, 0, 0, 1.0, "N/m")
#define VESPER_UNIT_NEWTON_SECOND_PER_METRE VESPER_UNIT_INIT(0, 1, -1, 0, 0, 0, 0, 1.0, "N*s/m")
#define VESPER_UNIT_KILOGRAM_METRE_SQUARED VESPER_UNIT_INIT(2, 1, 0, 0, 0, 0, 0, 1.0, "kg*m^2")
#define VESPER_UNIT_KILOGRAM_PER_METRE VESPER_UNIT_INIT(-1, 1, 0, 0, 0, 0, 0, 1.0, "kg/m")
#define VESPER_UNIT_KILOGRAM_PER_SECOND VESPER_UNIT_INIT(0, 1, -1, 0, 0, 0, 0, 1.0, "kg/s")
#define VESPER_UNIT_VOLT_PER_METRE VESPER_UNIT_INIT(1, 1, -3, -1, 0, 0, 0, 1.0, "V/m")
#define VESPER_UNIT_TESLA VESPER_UNIT_INIT(0, 1, -2, -1, 0, 0, 0, 1.0, "T")
#define VESPER_UNIT_GRAVITATIONAL_CONSTANT \
  VESPER_UNIT_INIT(3, -1, -2, 0, 0, 0, 0, 1.0, "m^3/(kg*s^2)")
#define VESPER_UNIT_COULOMB_CONSTANT VESPER_UNIT_INIT(3, 1, -4, -2, 0, 0, 0, 1.0, "N*m^2/C^2")
/** @} */

#endif /* VESPER_UNITS_H_ */
