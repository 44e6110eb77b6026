# What a run leaves behind: frames, series, picture, hash, and a description of the machine.
find_package(embree 3 REQUIRED)
find_package(VTK 9.1 REQUIRED COMPONENTS CommonCore CommonDataModel IOXML IOImage RenderingCore RenderingFreeType)

# The commit is looked up at each build, but its one small source is rewritten, and compiled, only when it changed.
set(PALPATE_COMMIT_SOURCE ${CMAKE_CURRENT_BINARY_DIR}/machine_commit.cpp)
add_custom_target(palpate_commit
  COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DOUTPUT=${PALPATE_COMMIT_SOURCE}
          -P ${CMAKE_CURRENT_LIST_DIR}/machine_commit.cmake
  BYPRODUCTS ${PALPATE_COMMIT_SOURCE}
  COMMENT "Looking up the git commit")

add_library(palpate_results STATIC
  atomic_file.cpp
  machine.cpp
  picture.cpp
  picture_caption.cpp
  picture_camera.cpp
  colour_scale.cpp
  picture_cut.cpp
  picture_text.cpp
  picture_image.cpp
  picture_normals.cpp
  picture_scene.cpp
  picture_shading.cpp
  series_writer.cpp
  vtu_writer.cpp
  ${PALPATE_COMMIT_SOURCE})
add_dependencies(palpate_results palpate_commit)
target_include_directories(palpate_results PUBLIC ${PROJECT_SOURCE_DIR}/src)
target_link_libraries(palpate_results
  PUBLIC palpate_internal
  PRIVATE embree VTK::CommonCore VTK::CommonDataModel VTK::IOXML VTK::IOImage VTK::RenderingCore VTK::RenderingFreeType)
# Fonts register themselves through this; without it no caption is drawn.
vtk_module_autoinit(TARGETS palpate_results MODULES VTK::RenderingFreeType)

string(JOIN " " PALPATE_BUILD_DESCRIPTION $<CONFIG> ${PALPATE_SANITIZE})
set_source_files_properties(machine.cpp PROPERTIES COMPILE_DEFINITIONS
  "PALPATE_COMPILER=\"${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}\";PALPATE_BUILD_TYPE=\"${PALPATE_BUILD_DESCRIPTION}\"")
