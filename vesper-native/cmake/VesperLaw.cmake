# SPDX-License-Identifier: Apache-2.0
# vesper_add_law(NAME source...)
#
# Defines the law library libvesper_law_NAME.so as a CMake target vesper_law_NAME: C or C++20, built
# with the SDK headers only, with `vesper_law_library_entry` as its only exported symbol.
set(VESPER_LAW_SYMBOLS ${CMAKE_CURRENT_LIST_DIR}/vesper_law.map)

function(vesper_add_law name)
  set(target vesper_law_${name})
  add_library(${target} MODULE ${ARGN})
  target_link_libraries(${target} PRIVATE Vesper::sdk)
  target_compile_features(${target} PRIVATE cxx_std_20)
  # -fno-gnu-unique: a unique symbol would keep the library mapped after it is unloaded.
  # -ffp-contract=off: same bits on every CPU; fused multiply-add only where it is written.
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -ffp-contract=off $<$<CXX_COMPILER_ID:GNU>:$<$<COMPILE_LANGUAGE:CXX>:-fno-gnu-unique>>)
  target_link_options(${target} PRIVATE
    LINKER:--no-undefined LINKER:--version-script=${VESPER_LAW_SYMBOLS})
  set_target_properties(${target} PROPERTIES
    PREFIX lib
    C_VISIBILITY_PRESET hidden
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    LINK_DEPENDS ${VESPER_LAW_SYMBOLS})
endfunction()
