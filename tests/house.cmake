# Tests of the house itself: layers, installed package, README.

# No room includes what is above it, and no OpenCASCADE header stands outside io/step/.
add_test(NAME layers
  COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/layers/check.cmake)
# ... and the check itself catches each planted breach, for its own reason.
add_test(NAME layers_selftest
  COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -DWORK=${CMAKE_CURRENT_BINARY_DIR}/layers_selftest
          -P ${CMAKE_CURRENT_SOURCE_DIR}/layers/selftest.cmake)

# The installed package serves an outside program.
add_test(NAME consumer
  COMMAND ${CMAKE_COMMAND}
    -DBUILD=${PROJECT_BINARY_DIR} -DSOURCE=${CMAKE_CURRENT_SOURCE_DIR}/consumer
    -DWORK=${CMAKE_CURRENT_BINARY_DIR}/consumer -DGENERATOR=${CMAKE_GENERATOR}
    -DCXX=${CMAKE_CXX_COMPILER} -DBUILD_TYPE=${CMAKE_BUILD_TYPE}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/run.cmake)
set_tests_properties(consumer PROPERTIES TIMEOUT 300)

# Every command that README.md and docs/winding.md mark as runnable runs.
if(EXISTS ${PROJECT_SOURCE_DIR}/README.md)
  add_test(NAME readme
    COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -DPAGES=README.md,docs/winding.md
      -DPROGRAM=$<TARGET_FILE:afptraj>
      -DWORK=${CMAKE_CURRENT_BINARY_DIR}/readme -P ${CMAKE_CURRENT_SOURCE_DIR}/readme/run.cmake)
  set_tests_properties(readme PROPERTIES ENVIRONMENT "${AFPTRAJ_TEST_ENVIRONMENT}")
endif()
