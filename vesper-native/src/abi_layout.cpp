// How this build lays out the structs of the contract, for bindings to check theirs against.
#include <cstddef>
#include <iterator>

#include "vesper/engine.h"

namespace {

#define STRUCT(type) {#type, nullptr, 0, static_cast<uint32_t>(sizeof(type))}
#define FIELD(type, field)                                   \
  {#type, #field, static_cast<uint32_t>(offsetof(type, field)), \
   static_cast<uint32_t>(sizeof(type::field))}

constexpr vesper_layout_entry kLayout[] = {
    STRUCT(vesper_unit),
    FIELD(vesper_unit, exponent),
    FIELD(vesper_unit, reserved),
    FIELD(vesper_unit, scale),
    FIELD(vesper_unit, symbol),

    STRUCT(vesper_error),
    FIELD(vesper_error, status),
    FIELD(vesper_error, library_id),
    FIELD(vesper_error, law_index),
    FIELD(vesper_error, stage),
    FIELD(vesper_error, row),
    FIELD(vesper_error, property),
    FIELD(vesper_error, message),

    STRUCT(vesper_field),
    FIELD(vesper_field, struct_size),
    FIELD(vesper_field, reserved),
    FIELD(vesper_field, user),
    FIELD(vesper_field, evaluate),

    STRUCT(vesper_parameter),
    FIELD(vesper_parameter, struct_size),
    FIELD(vesper_parameter, reserved),
    FIELD(vesper_parameter, name),
    FIELD(vesper_parameter, value),

    STRUCT(vesper_property_descriptor),
    FIELD(vesper_property_descriptor, struct_size),
    FIELD(vesper_property_descriptor, scalar_type),
    FIELD(vesper_property_descriptor, name),
    FIELD(vesper_property_descriptor, kind),
    FIELD(vesper_property_descriptor, components),
    FIELD(vesper_property_descriptor, law_access),
    FIELD(vesper_property_descriptor, unit),
    FIELD(vesper_property_descriptor, refers_to),
    FIELD(vesper_property_descriptor, initial_from),
    FIELD(vesper_property_descriptor, doc),

    STRUCT(vesper_prototype),
    FIELD(vesper_prototype, struct_size),
    FIELD(vesper_prototype, real_type),
    FIELD(vesper_prototype, name),
    FIELD(vesper_prototype, time_unit),
    FIELD(vesper_prototype, property_count),
    FIELD(vesper_prototype, reserved),
    FIELD(vesper_prototype, properties),

    STRUCT(vesper_property),
    FIELD(vesper_property, struct_size),
    FIELD(vesper_property, scalar_type),
    FIELD(vesper_property, name),
    FIELD(vesper_property, kind),
    FIELD(vesper_property, components),
    FIELD(vesper_property, access),
    FIELD(vesper_property, data),
    FIELD(vesper_property, row_count),
    FIELD(vesper_property, version),

    STRUCT(vesper_host),
    FIELD(vesper_host, struct_size),
    FIELD(vesper_host, reserved),
    FIELD(vesper_host, context),
    FIELD(vesper_host, log),
    FIELD(vesper_host, parallel_for),

    STRUCT(vesper_step),
    FIELD(vesper_step, struct_size),
    FIELD(vesper_step, stage),
    FIELD(vesper_step, stage_count),
    FIELD(vesper_step, reserved),
    FIELD(vesper_step, dt),
    FIELD(vesper_step, time),
    FIELD(vesper_step, index),

    STRUCT(vesper_property_use),
    FIELD(vesper_property_use, struct_size),
    FIELD(vesper_property_use, scalar_type),
    FIELD(vesper_property_use, name),
    FIELD(vesper_property_use, kind),
    FIELD(vesper_property_use, components),
    FIELD(vesper_property_use, access),
    FIELD(vesper_property_use, unit),
    FIELD(vesper_property_use, flags),
    FIELD(vesper_property_use, reserved),

    STRUCT(vesper_parameter_desc),
    FIELD(vesper_parameter_desc, struct_size),
    FIELD(vesper_parameter_desc, reserved),
    FIELD(vesper_parameter_desc, name),
    FIELD(vesper_parameter_desc, doc),
    FIELD(vesper_parameter_desc, unit),
    FIELD(vesper_parameter_desc, default_value),
    FIELD(vesper_parameter_desc, minimum),
    FIELD(vesper_parameter_desc, maximum),

    STRUCT(vesper_law_desc),
    FIELD(vesper_law_desc, struct_size),
    FIELD(vesper_law_desc, real_type),
    FIELD(vesper_law_desc, name),
    FIELD(vesper_law_desc, version),
    FIELD(vesper_law_desc, doc),
    FIELD(vesper_law_desc, phase),
    FIELD(vesper_law_desc, stages),
    FIELD(vesper_law_desc, use_count),
    FIELD(vesper_law_desc, parameter_count),
    FIELD(vesper_law_desc, uses),
    FIELD(vesper_law_desc, parameters),
    FIELD(vesper_law_desc, claims),
    FIELD(vesper_law_desc, reserved),
    FIELD(vesper_law_desc, create),
    FIELD(vesper_law_desc, bind),
    FIELD(vesper_law_desc, advance),
    FIELD(vesper_law_desc, destroy),
    FIELD(vesper_law_desc, potential_energy),
    FIELD(vesper_law_desc, synchronize),

    STRUCT(vesper_field_desc),
    FIELD(vesper_field_desc, struct_size),
    FIELD(vesper_field_desc, components),
    FIELD(vesper_field_desc, name),
    FIELD(vesper_field_desc, doc),
    FIELD(vesper_field_desc, unit),
    FIELD(vesper_field_desc, evaluate),

    STRUCT(vesper_law_library),
    FIELD(vesper_law_library, struct_size),
    FIELD(vesper_law_library, abi_version),
    FIELD(vesper_law_library, name),
    FIELD(vesper_law_library, law_count),
    FIELD(vesper_law_library, reserved),
    FIELD(vesper_law_library, laws),
    FIELD(vesper_law_library, open),
    FIELD(vesper_law_library, close),
    FIELD(vesper_law_library, field_count),
    FIELD(vesper_law_library, reserved1),
    FIELD(vesper_law_library, fields),

    STRUCT(vesper_provided_property),
    FIELD(vesper_provided_property, struct_size),
    FIELD(vesper_provided_property, reserved),
    FIELD(vesper_provided_property, data),
    FIELD(vesper_provided_property, value_count),
    FIELD(vesper_provided_property, indices),
    FIELD(vesper_provided_property, object_count),
    FIELD(vesper_provided_property, version),
    FIELD(vesper_provided_property, field),

    STRUCT(vesper_provider_callbacks),
    FIELD(vesper_provider_callbacks, struct_size),
    FIELD(vesper_provider_callbacks, reserved),
    FIELD(vesper_provider_callbacks, user),
    FIELD(vesper_provider_callbacks, find),
    FIELD(vesper_provider_callbacks, version),

    STRUCT(vesper_engine_config),
    FIELD(vesper_engine_config, struct_size),
    FIELD(vesper_engine_config, threads),
    FIELD(vesper_engine_config, validate),
    FIELD(vesper_engine_config, probe_timeout_ms),
    FIELD(vesper_engine_config, law_path),
    FIELD(vesper_engine_config, probe_path),
    FIELD(vesper_engine_config, log),
    FIELD(vesper_engine_config, log_user),
    FIELD(vesper_engine_config, deferred),
    FIELD(vesper_engine_config, reserved),

    STRUCT(vesper_law_info),
    FIELD(vesper_law_info, struct_size),
    FIELD(vesper_law_info, library_id),
    FIELD(vesper_law_info, library),
    FIELD(vesper_law_info, name),
    FIELD(vesper_law_info, version),
    FIELD(vesper_law_info, doc),
    FIELD(vesper_law_info, phase),
    FIELD(vesper_law_info, stages),
    FIELD(vesper_law_info, use_count),
    FIELD(vesper_law_info, parameter_count),
    FIELD(vesper_law_info, uses),
    FIELD(vesper_law_info, parameters),
    FIELD(vesper_law_info, calls),
    FIELD(vesper_law_info, nanoseconds),

    STRUCT(vesper_layout_entry),
    FIELD(vesper_layout_entry, struct_name),
    FIELD(vesper_layout_entry, field),
    FIELD(vesper_layout_entry, offset),
    FIELD(vesper_layout_entry, size),
};

static_assert(sizeof(vesper_error) == 256 && sizeof(vesper_unit) == 32, "these two are frozen");

}  // namespace

const vesper_layout_entry* vesper_abi_layout(uint32_t* count) noexcept {
  if (count != nullptr) *count = static_cast<uint32_t>(std::size(kLayout));
  return kLayout;
}
