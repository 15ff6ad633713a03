// SPDX-License-Identifier: Apache-2.0
/* A spring to the origin and semi-implicit Euler, which keep copies of position, velocity and
 * force in their suite: DEFERRED. Compile definitions: NAME, FLAGS (0: the same sums on the
 * arrays), LAW_FROM and LAW_TO (which of the two laws exist), and the unit of length. */
#define USE_COUNT 4
#define PARAMETER_COUNT 5
#include "test_law.h"

enum { kStiffness, kTalk, kCheat, kSkip, kSpoil };

typedef struct {
  double* data;
  uint64_t rows;
  uint64_t version;
} Copy;

struct vesper_suite {
  Copy position, velocity, force;
};

static vesper_status Open(const vesper_host* host, vesper_suite** out, vesper_error* error) {
  (void)host;
  *out = calloc(1, sizeof **out);
  return *out != NULL ? VESPER_OK : Fail(error, VESPER_LAW_FAILED, "out of memory");
}

static void Close(vesper_suite* suite) {
  free(suite->position.data);
  free(suite->velocity.data);
  free(suite->force.data);
  free(suite);
}

static Copy* CopyOf(vesper_law* law, const vesper_property* property) {
  if (strcmp(property->name, "position") == 0) return &law->suite->position;
  if (strcmp(property->name, "velocity") == 0) return &law->suite->velocity;
  if (strcmp(property->name, "externalForce") == 0) return &law->suite->force;
  return NULL;
}

static void Say(vesper_law* law, const char* verb, const char* name) {
  char line[64];
  if (law->parameters[kTalk] == 0) return;
  snprintf(line, sizeof line, "%s %s", verb, name);
  law->host->log(law->host->context, VESPER_LOG_INFO, line);
}

static vesper_status BindCopies(vesper_law* law, const vesper_property* properties,
                                vesper_error* error) {
  Bind(law, properties, error);
  for (int i = 0; FLAGS != 0 && i < USE_COUNT; ++i) {
    const vesper_property* property = &properties[i];
    Copy* copy = CopyOf(law, property);
    if (copy == NULL || copy->version == property->version) continue;
    copy->version = property->version;
    if (copy->rows != property->row_count) {
      free(copy->data);
      copy->rows = property->row_count;
      copy->data = malloc(3 * sizeof(double) * copy->rows + 1);
    }
    if (property->access == VESPER_ACCUMULATE || copy->rows == 0) continue;
    Say(law, "take", property->name);
    memcpy(copy->data, property->data, 3 * sizeof(double) * copy->rows);
  }
  return VESPER_OK;
}

/* Returns the copy of a use, or the array if the use is not deferred. */
static double* Values(vesper_law* law, int use) {
  return FLAGS != 0 ? CopyOf(law, &law->bound[use])->data : law->bound[use].data;
}

static vesper_status Pull(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)error;
  const double* position = Values(law, 1);
  double* force = Values(law, 2);
  for (uint64_t i = 0; i < 3 * law->bound[1].row_count; ++i) {
    force[i] = -law->parameters[kStiffness] * position[i];
  }
  if (law->parameters[kSpoil] == 1 && step->index == 2) force[7] = NAN;
  if (law->parameters[kCheat] == 1) ((double*)law->bound[2].data)[3] = 1;
  return VESPER_OK;
}

static vesper_status Energy(vesper_law* law, double* out, vesper_error* error) {
  (void)error;
  const double* position = Values(law, 1);
  *out = 0;
  for (uint64_t i = 0; i < 3 * law->bound[1].row_count; ++i) {
    *out += law->parameters[kStiffness] / 2 * position[i] * position[i];
  }
  return VESPER_OK;
}

static vesper_status Move(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)error;
  if (step->stage == 0) return VESPER_OK;
  const double* mass = law->bound[0].data;
  double* position = Values(law, 1);
  const double* force = Values(law, 2);
  double* velocity = Values(law, 3);
  for (uint64_t row = 0; row < law->bound[0].row_count; ++row) {
    for (uint64_t i = 3 * row; i < 3 * row + 3; ++i) {
      velocity[i] += force[i] / mass[row] * step->dt;
      position[i] += velocity[i] * step->dt;
    }
  }
  if (law->parameters[kSpoil] == 1 && step->index == 2) position[4] = NAN;
  return VESPER_OK;
}

static vesper_status Synchronize(vesper_law* law, uint32_t use, vesper_error* error) {
  (void)error;
  const vesper_property* property = &law->bound[use];
  Say(law, "write", property->name);
  uint64_t rows = property->row_count;
  if (law->parameters[kSkip] == 1 && rows > 0) --rows;
  if (rows > 0) memcpy(property->data, CopyOf(law, property)->data, 3 * sizeof(double) * rows);
  return VESPER_OK;
}

#define VALUES_USE(name, access, unit) \
  {sizeof(vesper_property_use), VESPER_F64, name, "body", 3, access, unit, FLAGS, 0}
static const vesper_property_use kPullUses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    VALUES_USE("position", VESPER_READ, LENGTH),
    VALUES_USE("externalForce", VESPER_ACCUMULATE, VESPER_UNIT_NEWTON),
    VALUES_USE("velocity", VESPER_READ, VESPER_UNIT_METRE_PER_SECOND)};
static const vesper_property_use kMoveUses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    VALUES_USE("position", VESPER_READ_WRITE, LENGTH),
    VALUES_USE("externalForce", VESPER_READ, VESPER_UNIT_NEWTON),
    VALUES_USE("velocity", VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("stiffness", VESPER_UNIT_NEWTON_PER_METRE, 2, 0, 1e6),
    PARAMETER("talk", VESPER_UNIT_ONE, 0, 0, 1), PARAMETER("cheat", VESPER_UNIT_ONE, 0, 0, 1),
    PARAMETER("skip", VESPER_UNIT_ONE, 0, 0, 1), PARAMETER("spoil", VESPER_UNIT_ONE, 0, 0, 1)};
#define VAULT_LAW(name, phase, stages, uses, act, energy) \
  {sizeof(vesper_law_desc),                               \
   VESPER_F64,                                            \
   name,                                                  \
   "1.0.0",                                               \
   "Keeps copies.",                                       \
   phase,                                                 \
   stages,                                                \
   USE_COUNT,                                             \
   PARAMETER_COUNT,                                       \
   uses,                                                  \
   kParameters,                                           \
   0,                                                     \
   0,                                                     \
   Create,                                                \
   BindCopies,                                            \
   act,                                                   \
   Destroy,                                               \
   energy,                                                \
   Synchronize,                                           \
   NULL,                                                  \
   0,                                                     \
   0}
static const vesper_law_desc kBoth[] = {
    VAULT_LAW("pull", VESPER_PHASE_FORCE, 0, kPullUses, Pull, Energy),
    VAULT_LAW("move", VESPER_PHASE_INTEGRATE, 1, kMoveUses, Move, NULL)};

const vesper_law_library* vesper_law_library_entry(void) {
  static const vesper_law_library library = {sizeof library,
                                             VESPER_ABI_VERSION,
                                             NAME,
                                             LAW_TO - LAW_FROM,
                                             0,
                                             kBoth + LAW_FROM,
                                             Open,
                                             Close,
                                             0,
                                             0,
                                             NULL,
                                             NULL};
  return &library;
}
