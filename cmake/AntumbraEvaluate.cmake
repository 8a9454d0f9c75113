# antumbra::evaluate: truth, walkthrough, report. The only library that needs GL and brings HTML.
find_package(PNG REQUIRED)
find_path(ANTUMBRA_GL_INCLUDE_DIR GL/glcorearb.h DOC "Headers of OpenGL (Debian: libgl-dev)" REQUIRED)
find_path(ANTUMBRA_EGL_INCLUDE_DIR EGL/eglext.h DOC "Headers of EGL (Debian: libegl-dev)" REQUIRED)
antumbra_library(evaluate evaluate)
target_include_directories(antumbra_evaluate PRIVATE ${ANTUMBRA_GL_INCLUDE_DIR} ${ANTUMBRA_EGL_INCLUDE_DIR})
# OpenGL itself is looked for when a walk runs: a machine without it measures everything but drawing.
target_link_libraries(antumbra_evaluate PUBLIC antumbra_antumbra ${CMAKE_DL_LIBS}
                      PRIVATE $<BUILD_INTERFACE:nlohmann_json::nlohmann_json> PNG::PNG)
