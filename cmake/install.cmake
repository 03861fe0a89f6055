# `cmake --install` puts the program, the rooms and their headers into place, with a package so that
# an outside program writes find_package(afptraj) and links afptraj::boundary (or another room).
include(CMakePackageConfigHelpers)

get_property(rooms GLOBAL PROPERTY AFPTRAJ_ROOMS)
foreach(room IN LISTS rooms)
  install(TARGETS afptraj_${room} EXPORT afptrajTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/afptraj)
endforeach()
if(TARGET afptraj)
  install(TARGETS afptraj RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/afptraj)
install(EXPORT afptrajTargets NAMESPACE afptraj:: DESTINATION ${package_dir})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/afptrajConfig.cmake.in
  ${PROJECT_BINARY_DIR}/afptrajConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/afptrajConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/afptrajConfig.cmake ${PROJECT_BINARY_DIR}/afptrajConfigVersion.cmake
  DESTINATION ${package_dir})
