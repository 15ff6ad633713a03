// SPDX-License-Identifier: Apache-2.0
/* A table that violates the rule of law.h named by DEFECT. */
#define USE_COUNT 2
#include "test_law.h"

#define NO_NAME 1
#define DUPLICATE_LAW 2
#define UNKNOWN_PHASE 3
#define INTEGRATOR_WITHOUT_STAGES 4
#define FORCE_WITH_STAGES 5
#define ACCUMULATE_WHEN_CONSTRAINING 6
#define DUPLICATE_USE 7
#define DEFAULT_OUT_OF_RANGE 8
#define OPEN_WITHOUT_CLOSE 9
#define NO_ADVANCE 10
#define BAD_VERSION 11
#define SHORT_STRUCT 12
#define NO_LAWS 13
#define UNKNOWN_CLAIM 14
#define FIELD_WITHOUT_FUNCTION 15
#define DEFERRED_WITHOUT_SYNCHRONIZE 16
#define WEIGHTS_OF_NOTHING 17
#define FORCE_WITH_FIRST_STAGE 18
#define FIRST_STAGE_BEYOND_ONE 19

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law;
  (void)step;
  (void)error;
  return VESPER_OK;
}

static vesper_status Open(const vesper_host* host, vesper_suite** out, vesper_error* error) {
  (void)host;
  (void)out;
  return Fail(error, VESPER_LAW_FAILED, "never called");
}

static vesper_property_use uses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    REAL_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
};
static vesper_parameter_desc parameters[] = {PARAMETER("p", VESPER_UNIT_ONE, 1, 0, 2)};
static const double weights[] = {0.5, 0.4};
static vesper_law_desc laws[] = {
    LAW("first", VESPER_PHASE_CONSTRAIN, 0, uses, USE_COUNT, parameters, 1, Create, Bind, Act),
    LAW("second", VESPER_PHASE_OBSERVE, 0, NULL, 0, NULL, 0, Create, Bind, Act),
};
static const vesper_field_desc fields[] = {
    {sizeof(vesper_field_desc), 3, "wind", "A field.", VESPER_UNIT_ONE, NULL, NULL, NULL, NULL}};
static vesper_law_library library = {
    sizeof library, VESPER_ABI_VERSION, "bad_table", 2, 0, laws, NULL, NULL, 0, 0, NULL, NULL};

const vesper_law_library* vesper_law_library_entry(void) {
  switch (DEFECT) {
    case NO_NAME:
      laws[0].name = NULL;
      break;
    case DUPLICATE_LAW:
      laws[1].name = "first";
      break;
    case UNKNOWN_PHASE:
      laws[0].phase = 9;
      break;
    case INTEGRATOR_WITHOUT_STAGES:
      laws[0].phase = VESPER_PHASE_INTEGRATE;
      break;
    case FORCE_WITH_STAGES:
      laws[0].stages = 1;
      break;
    case ACCUMULATE_WHEN_CONSTRAINING:
      uses[1].access = VESPER_ACCUMULATE;
      break;
    case DUPLICATE_USE:
      uses[1].name = "mass";
      break;
    case DEFAULT_OUT_OF_RANGE:
      parameters[0].default_value = 3;
      break;
    case OPEN_WITHOUT_CLOSE:
      library.open = Open;
      break;
    case NO_ADVANCE:
      laws[0].advance = NULL;
      break;
    case BAD_VERSION:
      laws[0].version = "1.0";
      break;
    case SHORT_STRUCT:
      laws[0].struct_size = 8;
      break;
    case NO_LAWS:
      library.law_count = 0;
      break;
    case FIELD_WITHOUT_FUNCTION:
      library.field_count = 1;
      library.fields = fields;
      break;
    case DEFERRED_WITHOUT_SYNCHRONIZE:
      uses[1].flags = VESPER_USE_DEFERRED;
      break;
    case WEIGHTS_OF_NOTHING:
      laws[0].phase = VESPER_PHASE_INTEGRATE;
      laws[0].stages = 1;
      laws[0].force_weights = weights;
      break;
    case UNKNOWN_CLAIM:
      laws[0].claims = 1u << 30;
      break;
    case FORCE_WITH_FIRST_STAGE:
      laws[0].first_stage = 1;
      break;
    case FIRST_STAGE_BEYOND_ONE:
      laws[0].phase = VESPER_PHASE_INTEGRATE;
      laws[0].stages = 4;
      laws[0].first_stage = 2;
      break;
    default:
      break;
  }
  return &library;
}
