# Install and export: find_package(antumbra) gives antumbra::runtime and antumbra::antumbra.
include(CMakePackageConfigHelpers)
install(TARGETS antumbra_runtime antumbra_antumbra EXPORT antumbra-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/antumbra DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT antumbra-targets NAMESPACE antumbra:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/antumbra)
configure_package_config_file(cmake/antumbra-config.cmake.in antumbra-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/antumbra)
write_basic_package_version_file(antumbra-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/antumbra-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/antumbra-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/antumbra)
