// SPDX-License-Identifier: Apache-2.0
#include "custom_provider.hpp"

#include "failure.hpp"
#include "unit.hpp"
#include "versioned_struct.hpp"

namespace vesper {

CustomProvider::CustomProvider(const vesper_provider_callbacks& callbacks,
                               const Prototype& prototype)
    : callbacks_(ReadStruct(callbacks, "callbacks")),
      prototype_(prototype),
      answers_(prototype.properties().size()) {
  if (callbacks_.find == nullptr || callbacks_.version == nullptr) {
    throw Failure(VESPER_INVALID_ARGUMENT, "callbacks.%s is null",
                  callbacks_.find == nullptr ? "find" : "version");
  }
}

void CustomProvider::Refresh(Columns& columns, const Check& check) {
  const uint64_t version = callbacks_.version(callbacks_.user);
  if (asked_ && version == version_) return;
  std::vector<Answer> answers;
  for (uint32_t i = 0; i < columns.size(); ++i) {
    answers.push_back(Ask(columns.spec(i)));
    if (!answers.back().known) continue;
    if (IsField(columns.spec(i).type)) {
      columns.CheckField(i, answers.back().field);
    } else {
      columns.Check(i, answers.back().arrays);
    }
    check(i, answers.back().arrays);
  }
  for (uint32_t i = 0; i < columns.size(); ++i) Bind(columns, i, answers_[i], answers[i]);
  answers_ = std::move(answers);
  asked_ = true;
  version_ = version;
}

CustomProvider::Answer CustomProvider::Ask(const PropertySpec& property) const {
  vesper_provided_property provided{};
  provided.struct_size = sizeof provided;
  vesper_error error = BlankError();
  const vesper_status status =
      callbacks_.find(callbacks_.user, property.name.c_str(), &provided, &error);
  if (status == VESPER_NOT_FOUND) return {};
  if (status == VESPER_OK) {
    return {true,
            {provided.data, provided.value_count, provided.indices, provided.object_count},
            provided.version,
            provided.field};
  }
  Sanitize(error);
  throw Failure(status, "property %s: the client's provider answers %s%s%s", property.name.c_str(),
                StatusName(status), error.message[0] != '\0' ? ": " : "", error.message)
      .Property(property.name);
}

void CustomProvider::Bind(Columns& columns, uint32_t property, const Answer& before,
                          const Answer& now) {
  if (!now.known) {
    if (before.known) columns.Remove(property);
  } else if (IsField(columns.spec(property).type)) {
    const bool same = before.known && now.version == before.version &&
                      now.field.user == before.field.user &&
                      now.field.evaluate == before.field.evaluate;
    if (!same) columns.SetField(property, now.field);
  } else if (!before.known || now.arrays != before.arrays) {
    columns.Provide(property, now.arrays);
  } else if (now.version != before.version) {
    columns.Touch(property);
  }
}

}  // namespace vesper
