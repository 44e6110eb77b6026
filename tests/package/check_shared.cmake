# Builds the library as a shared one, with the mesh readers, installs it, and uses it by CMake and by pkg-config.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE "${WORK_DIR}/prefix" "${WORK_DIR}/embed")
run(${CMAKE_COMMAND} -S "${SOURCE_DIR}" -B "${WORK_DIR}/library" -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}"
    -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON -DPALPATE_BUILD_TOOLS=OFF -DPALPATE_BUILD_TESTS=OFF
    -DPALPATE_BUILD_BENCH=OFF -DPALPATE_BUILD_IO=ON)
run(${CMAKE_COMMAND} --build "${WORK_DIR}/library")
run(${CMAKE_COMMAND} --install "${WORK_DIR}/library" --prefix "${WORK_DIR}/prefix")
run(${CMAKE_COMMAND} -S "${SOURCE_DIR}/examples/embed" -B "${WORK_DIR}/embed" -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}"
    -DCMAKE_BUILD_TYPE=Release "-DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix" -DCMAKE_DISABLE_FIND_PACKAGE_hwy=ON)
run(${CMAKE_COMMAND} --build "${WORK_DIR}/embed")
run("${WORK_DIR}/embed/embed")
check_embed("${output}")
run(ldd "${WORK_DIR}/embed/embed")
if(NOT output MATCHES "libpalpate\\.so\\.0")
  message(FATAL_ERROR "embed does not use the shared library:\n${output}")
endif()

find_program(pkg_config pkg-config REQUIRED)
file(GLOB_RECURSE pc "${WORK_DIR}/prefix/palpate.pc")
get_filename_component(folder "${pc}" DIRECTORY)
get_filename_component(libraries "${folder}" DIRECTORY)
run(sh -c "export PKG_CONFIG_PATH='${folder}' && eval \"$1\" -std=c++20 -O1 -o \"'$3'\" \"'$2'\" \"$(pkg-config --cflags --libs palpate)\""
    sh "${CXX}" "${SOURCE_DIR}/examples/embed/main.cpp" "${WORK_DIR}/by_pkg_config")
run(${CMAKE_COMMAND} -E env "LD_LIBRARY_PATH=${libraries}" "${WORK_DIR}/by_pkg_config")
check_embed("${output}")
run(sh -c "export PKG_CONFIG_PATH='${folder}' && eval \"$1\" -std=c++20 -O1 -o \"'$3'\" \"'$2'\" \"$(pkg-config --cflags --libs palpate-io)\""
    sh "${CXX}" "${SOURCE_DIR}/examples/mesh_file/main.cpp" "${WORK_DIR}/mesh_file_by_pkg_config")
run(${CMAKE_COMMAND} -E env "LD_LIBRARY_PATH=${libraries}" ldd "${WORK_DIR}/by_pkg_config")
string(FIND "${output}" " => ${libraries}/libpalpate.so.0" found)
if(found EQUAL -1)
  message(FATAL_ERROR "by_pkg_config does not use the shared library:\n${output}")
endif()
