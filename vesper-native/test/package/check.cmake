# SPDX-License-Identifier: Apache-2.0
# cmake -DVESPER_BUILD=… -DWORK=… -DINSTALL=ON|OFF -P check.cmake
#
# Builds and runs a law and a client outside the source tree, with the build tree or an
# installation.
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
set(package ${VESPER_BUILD})
if(INSTALL)
  run(${CMAKE_COMMAND} --install ${VESPER_BUILD} --prefix ${WORK}/prefix)
  file(GLOB_RECURSE config ${WORK}/prefix/*/VesperConfig.cmake)
  get_filename_component(package ${config} DIRECTORY)
  run(${WORK}/prefix/bin/vesper --version)
  run(${WORK}/prefix/bin/vesper-render --version)
endif()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G Ninja -DVesper_DIR=${package})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/client ${WORK}/build/libvesper_law_outside.so)
