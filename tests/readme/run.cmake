# Runs every block of the PAGES (README.md, docs/...) that begins with the line "# runnable" in a copy of samples/, with
# the built program first in the path. A block fails when one of its commands fails.
#   cmake -DROOT= -DPAGES=README.md,docs/winding.md -DPROGRAM= -DWORK= -P run.cmake
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
file(COPY ${ROOT}/samples DESTINATION ${WORK})
get_filename_component(program_folder ${PROGRAM} DIRECTORY)
set(ENV{PATH} "${program_folder}:$ENV{PATH}")

string(REPLACE "," ";" pages "${PAGES}")
foreach(page IN LISTS pages)
  file(READ ${ROOT}/${page} text)
  set(count 0)
  while(text MATCHES "```sh\n# runnable\n([^`]*)```")
    set(block "${CMAKE_MATCH_1}")
    string(FIND "${text}" "```sh\n# runnable\n" at)
    math(EXPR at "${at} + 10")
    string(SUBSTRING "${text}" ${at} -1 text)
    math(EXPR count "${count} + 1")
    file(WRITE ${WORK}/block.sh "set -e\n${block}")
    execute_process(COMMAND sh ${WORK}/block.sh WORKING_DIRECTORY ${WORK}
      RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
      message(FATAL_ERROR "${page}, runnable block ${count} fails with ${result}:\n${block}\n${output}")
    endif()
  endwhile()
  if(count EQUAL 0)
    message(FATAL_ERROR "${page} has no runnable block")
  endif()
  message(STATUS "${page}: ${count} blocks run")
endforeach()
