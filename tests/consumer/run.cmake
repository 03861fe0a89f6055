# Installs the build into a scratch directory and builds and runs an outside program against it.
#   cmake -DBUILD= -DSOURCE= -DWORK= -DGENERATOR= -DCXX= -DBUILD_TYPE= -P run.cmake
cmake_minimum_required(VERSION 3.25)

function(must name)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${name} failed:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
must(install ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
must(configure ${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR}
  -DCMAKE_PREFIX_PATH=${WORK}/installed -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_BUILD_TYPE=${BUILD_TYPE})
must(build ${CMAKE_COMMAND} --build ${WORK}/build)
must(run ${WORK}/build/consumer)

# R = 350, 1000 sqrt(2) mm at 45 degrees from 0.5 rad: the helix ends at 0.5 + 1000 / 350 rad, 1000 up.
string(STRIP "${output}" output)
set(expected "-341.900602 -74.859726 1000.000000")
if(NOT output STREQUAL expected)
  message(FATAL_ERROR "the outside program prints '${output}', the helix ends at '${expected}'")
endif()
message(STATUS "consumer: ${output}")
