# The page: npm ci when its packages changed, vite build when anything changed. Without npm the command builds
# without the page, and says so when asked for it.
find_program(PALPATE_NPM npm)
set(viewer ${PROJECT_SOURCE_DIR}/viewer)
if(NOT PALPATE_NPM)
  message(STATUS "npm is missing: `palpate view` will have no page (apt-get install nodejs npm)")
  target_sources(palpate_view PRIVATE page_missing.cpp)
  return()
endif()

set(PALPATE_PAGE ${PROJECT_BINARY_DIR}/viewer)
set(packages ${PALPATE_PAGE}/packages.stamp)
set(files ${PALPATE_PAGE}/index.html ${PALPATE_PAGE}/app.js ${PALPATE_PAGE}/app.css)
file(GLOB_RECURSE page_sources CONFIGURE_DEPENDS ${viewer}/src/*)
add_custom_command(OUTPUT ${packages}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${PALPATE_PAGE}
  COMMAND ${PALPATE_NPM} ci --no-audit --no-fund --loglevel=error
  COMMAND ${CMAKE_COMMAND} -E touch ${packages}
  DEPENDS ${viewer}/package.json ${viewer}/package-lock.json
  WORKING_DIRECTORY ${viewer} COMMENT "Fetching the packages of the page" VERBATIM)
add_custom_command(OUTPUT ${files}
  COMMAND ${PALPATE_NPM} run --silent build -- --outDir ${PALPATE_PAGE} --logLevel warn
  COMMAND ${CMAKE_COMMAND} -E touch ${files}
  DEPENDS ${packages} ${page_sources} ${viewer}/index.html ${viewer}/vite.config.ts ${viewer}/tsconfig.json
  WORKING_DIRECTORY ${viewer} COMMENT "Building the page" VERBATIM)
configure_file(page_built.cpp.in ${CMAKE_CURRENT_BINARY_DIR}/page_built.cpp @ONLY)
set_source_files_properties(${CMAKE_CURRENT_BINARY_DIR}/page_built.cpp PROPERTIES OBJECT_DEPENDS "${files}")
target_sources(palpate_view PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/page_built.cpp)
