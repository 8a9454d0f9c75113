# Flags that every target of the project shares. -ffp-contract=off and the absence of -ffast-math keep
# results identical on every machine (docs/decisions/0001-determinism.md).
add_library(antumbra_flags INTERFACE)
target_compile_features(antumbra_flags INTERFACE cxx_std_20 c_std_99)
target_compile_options(antumbra_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -ffp-contract=off)
# GCC 12 sees overlapping copies in every "text" + std::string (GCC bug 105651).
target_compile_options(antumbra_flags INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-restrict>)
if(ANTUMBRA_WERROR)
  target_compile_options(antumbra_flags INTERFACE -Werror)
endif()
if(ANTUMBRA_SANITIZE)
  target_compile_options(antumbra_flags INTERFACE -fsanitize=${ANTUMBRA_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(antumbra_flags INTERFACE -fsanitize=${ANTUMBRA_SANITIZE})
endif()

# antumbra_library(NAME MODULE..): one library out of the folders src/MODULE and their folders, exported as
# antumbra::NAME.
function(antumbra_library name)
  set(patterns)
  foreach(module ${ARGN})
    list(APPEND patterns src/${module}/*.cpp src/${module}/*.hpp src/${module}/*/*.cpp src/${module}/*/*.hpp)
  endforeach()
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  add_library(antumbra_${name} STATIC ${sources})
  add_library(antumbra::${name} ALIAS antumbra_${name})
  set_target_properties(antumbra_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(antumbra_${name}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_features(antumbra_${name} PUBLIC cxx_std_20)
  target_link_libraries(antumbra_${name} PRIVATE $<BUILD_INTERFACE:antumbra_flags>)
endfunction()
