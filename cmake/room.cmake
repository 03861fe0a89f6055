# One room of the house: a folder, a layer and a target `afptraj_<room>` (alias afptraj::<room>).
#
#   afptraj_room(geometry SOURCES a.cpp ... HEADERS a.h ... USES <rooms and libraries>)
#
# Every public header is compiled alone (target afptraj_<room>_verify_interface_header_sets,
# part of `all_verify_interface_header_sets`).
function(afptraj_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;HEADERS;USES;PRIVATE" ${ARGN})
  add_library(afptraj_${name} STATIC ${ROOM_SOURCES})
  add_library(afptraj::${name} ALIAS afptraj_${name})
  set_target_properties(afptraj_${name} PROPERTIES
    EXPORT_NAME ${name}
    VERIFY_INTERFACE_HEADER_SETS ON)
  target_sources(afptraj_${name} PUBLIC FILE_SET HEADERS
    BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ROOM_HEADERS})
  target_compile_features(afptraj_${name} PUBLIC cxx_std_20)
  target_link_libraries(afptraj_${name} PUBLIC ${ROOM_USES} PRIVATE ${ROOM_PRIVATE})
  afptraj_strict(afptraj_${name})
  set_property(GLOBAL APPEND PROPERTY AFPTRAJ_ROOMS ${name})
endfunction()

# Warnings are errors; sanitizers where asked for.
function(afptraj_strict target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Werror)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC 12 sees an overlap in "text" + std::string that is not there (GCC bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(AFPTRAJ_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
  endif()
endfunction()
