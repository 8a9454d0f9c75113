# The viewer's page: web/viewer with the package web/antumbra, bundled by Vite into one document that opens from disk. It
# becomes part of the program (`antumbra view`) and is installed beside it.
find_program(ANTUMBRA_NODE NAMES node nodejs DOC "Node, which bundles the viewer" REQUIRED)
set(viewer ${PROJECT_SOURCE_DIR}/web/viewer)
if(NOT EXISTS ${viewer}/node_modules/vite/bin/vite.js)
  message(FATAL_ERROR "What bundles the viewer is not installed in web/viewer: run tools/setup (or `npm ci` there), "
                      "or configure with -DANTUMBRA_BUILD_WEB=OFF: then there is no `antumbra view`")
endif()
set(viewer_page ${PROJECT_BINARY_DIR}/viewer/index.html)
file(GLOB viewer_sources CONFIGURE_DEPENDS ${viewer}/src/*.ts ${viewer}/src/*.css ${PROJECT_SOURCE_DIR}/web/antumbra/src/*.js)
add_custom_command(
  OUTPUT ${viewer_page}
  COMMAND ${CMAKE_COMMAND} -E env ANTUMBRA_VIEWER_OUT=${PROJECT_BINARY_DIR}/viewer
          ${ANTUMBRA_NODE} node_modules/vite/bin/vite.js build --logLevel warn
  WORKING_DIRECTORY ${viewer}
  DEPENDS antumbra_wasm ${wasm_scripts} ${viewer_sources} ${viewer}/index.html ${viewer}/vite.config.js
          ${viewer}/package-lock.json
  COMMENT "Bundling the viewer" VERBATIM)
set(viewer_code ${PROJECT_BINARY_DIR}/viewer_page.cpp)
add_custom_command(
  OUTPUT ${viewer_code}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${viewer_code} -DHEADER=view_server.hpp -DNAMESPACE=antumbra::app
          -DPARTS=viewer_page=${viewer_page} -P ${CMAKE_CURRENT_LIST_DIR}/EmbedText.cmake
  DEPENDS ${viewer_page} ${CMAKE_CURRENT_LIST_DIR}/EmbedText.cmake
  COMMENT "Embedding the viewer" VERBATIM)
add_custom_target(antumbra_viewer DEPENDS ${viewer_page})
install(FILES ${viewer_page} DESTINATION ${CMAKE_INSTALL_DATADIR}/antumbra/viewer)
