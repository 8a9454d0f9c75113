# antumbra::evaluate: truth, walkthrough, report. The only library that needs GL and brings HTML.
find_package(PNG REQUIRED)
find_path(ANTUMBRA_GL_INCLUDE_DIR GL/glcorearb.h DOC "Headers of OpenGL (Debian: libgl-dev)" REQUIRED)
find_path(ANTUMBRA_EGL_INCLUDE_DIR EGL/eglext.h DOC "Headers of EGL (Debian: libegl-dev)" REQUIRED)
antumbra_library(evaluate evaluate)
target_include_directories(antumbra_evaluate PRIVATE ${ANTUMBRA_GL_INCLUDE_DIR} ${ANTUMBRA_EGL_INCLUDE_DIR})
# OpenGL itself is looked for when a walk runs: a machine without it measures everything but drawing.
target_link_libraries(antumbra_evaluate PUBLIC antumbra_antumbra ${CMAKE_DL_LIBS}
                      PRIVATE $<BUILD_INTERFACE:nlohmann_json::nlohmann_json> PNG::PNG)

# The report's page, with the plotting library from npm, becomes part of the program.
set(uplot ${PROJECT_SOURCE_DIR}/tools/report/node_modules/uplot/dist)
set(report ${PROJECT_SOURCE_DIR}/src/evaluate/report)
if(NOT EXISTS ${uplot}/uPlot.iife.min.js)
  message(FATAL_ERROR "uPlot, which the HTML report carries, is not installed in tools/report: run tools/setup "
                      "(or `npm ci` there), or configure with -DANTUMBRA_BUILD_EVALUATE=OFF")
endif()
set(parts report_template=${report}/template.html report_style=${report}/report.css
    report_script=${report}/report.js uplot_style=${uplot}/uPlot.min.css uplot_script=${uplot}/uPlot.iife.min.js)
set(page ${CMAKE_CURRENT_BINARY_DIR}/report_page.cpp)
add_custom_command(
  OUTPUT ${page}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${page} -DHEADER=evaluate/report/report_page.hpp -DNAMESPACE=antumbra
          "-DPARTS=${parts}" -P ${CMAKE_CURRENT_LIST_DIR}/EmbedText.cmake
  DEPENDS ${report}/template.html ${report}/report.css ${report}/report.js ${uplot}/uPlot.min.css
          ${uplot}/uPlot.iife.min.js ${CMAKE_CURRENT_LIST_DIR}/EmbedText.cmake
  COMMENT "Embedding the report's page" VERBATIM)
target_sources(antumbra_evaluate PRIVATE ${page})
