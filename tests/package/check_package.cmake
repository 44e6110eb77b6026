# Installs BUILD_DIR below WORK_DIR, checks each installed header, then builds and runs examples/embed against it.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# The prefix is not the one that was configured: a package that names build or source paths would fail.
set(prefix "${WORK_DIR}/pre fix")
file(REMOVE_RECURSE "${WORK_DIR}")
run(${CMAKE_COMMAND} --install "${BUILD_DIR}" --prefix "${prefix}")

# Every public header is installed, compiles alone, and needs only the standard library and other public headers.
file(GLOB public RELATIVE "${SOURCE_DIR}/include/palpate" "${SOURCE_DIR}/include/palpate/*.hpp")
foreach(header IN LISTS public ITEMS version.hpp)
  set(file "${prefix}/include/palpate/${header}")
  if(NOT EXISTS "${file}")
    message(FATAL_ERROR "${header} is not installed")
  endif()
  run("${CXX}" -std=c++20 -Wall -Wextra -Werror -fsyntax-only "-I${prefix}/include" -include "palpate/${header}"
      -x c++ /dev/null)
  file(STRINGS "${file}" includes REGEX "^ *# *include")
  foreach(line IN LISTS includes)
    if(NOT line MATCHES "^#include <(palpate/[a-z_]+[.]hpp|[a-z_]+)>$")
      message(FATAL_ERROR "${header} includes what a user may not have: ${line}")
    endif()
  endforeach()
endforeach()

# Nothing that is installed may lead back to this machine's build or source folder.
file(GLOB_RECURSE package_files "${prefix}/*.cmake")
foreach(file IN LISTS package_files)
  file(READ "${file}" text)
  foreach(folder IN ITEMS "${BUILD_DIR}" "${SOURCE_DIR}")
    string(FIND "${text}" "${folder}/" found)
    if(NOT found EQUAL -1)
      message(FATAL_ERROR "${file} names ${folder}")
    endif()
  endforeach()
endforeach()

# A consumer without any package of ours.
set(flags "-Wall -Wextra -Werror")
if(SANITIZE)
  string(APPEND flags " -fsanitize=${SANITIZE}")
endif()
set(without "")
foreach(package IN ITEMS OpenMP Boost VTK embree fmt spdlog nlohmann_json CLI11 GTest Eigen3 benchmark)
  list(APPEND without -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
run(${CMAKE_COMMAND} -S "${SOURCE_DIR}/examples/embed" -B "${WORK_DIR}/embed" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${prefix}" "-DCMAKE_CXX_COMPILER=${CXX}" -DCMAKE_BUILD_TYPE=Release
    "-DCMAKE_CXX_FLAGS=${flags}" ${without})
file(STRINGS "${WORK_DIR}/embed/CMakeCache.txt" found REGEX "^palpate_DIR:")
if(NOT found MATCHES "=${WORK_DIR}/")
  message(FATAL_ERROR "another palpate was found: ${found}")
endif()
run(${CMAKE_COMMAND} --build "${WORK_DIR}/embed")
run("${WORK_DIR}/embed/embed")

check_embed("${output}")

# The umbrella header has every other one.
file(READ "${prefix}/include/palpate/palpate.hpp" umbrella)
foreach(header IN LISTS public ITEMS version.hpp)
  if(NOT header STREQUAL palpate.hpp AND NOT umbrella MATCHES "#include <palpate/${header}>")
    message(FATAL_ERROR "palpate/palpate.hpp does not include ${header}")
  endif()
endforeach()

# A prefix is not a place for Python modules.
file(GLOB_RECURSE stray "${prefix}/*.py" "${prefix}/*.pyi" "${prefix}/*/py.typed" "${prefix}/*/_core*.so")
if(stray OR EXISTS "${prefix}/palpate")
  message(FATAL_ERROR "Python files in the prefix: ${stray}")
endif()

# pkg-config, for builds without CMake.
find_program(pkg_config pkg-config)
if(pkg_config AND NOT SANITIZE)
  file(GLOB_RECURSE pc "${prefix}/palpate.pc")
  get_filename_component(folder "${pc}" DIRECTORY)
  run(sh -c "export PKG_CONFIG_PATH='${folder}' && eval \"$1\" -std=c++20 -O1 -o \"'$3'\" \"'$2'\" \"$(pkg-config --cflags --libs palpate)\""
      sh "${CXX}" "${SOURCE_DIR}/examples/embed/main.cpp" "${WORK_DIR}/by_pkg_config")
  run("${WORK_DIR}/by_pkg_config")
  check_embed("${output}")
endif()

# Mesh readers: a tet of volume 1/6, in the simplest format there is.
run(${CMAKE_COMMAND} -S "${SOURCE_DIR}/examples/mesh_file" -B "${WORK_DIR}/mesh_file" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${prefix}" "-DCMAKE_CXX_COMPILER=${CXX}" -DCMAKE_BUILD_TYPE=Release
    "-DCMAKE_CXX_FLAGS=${flags}" ${without})
run(${CMAKE_COMMAND} --build "${WORK_DIR}/mesh_file")
file(WRITE "${WORK_DIR}/tet.mesh" "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
  "Tetrahedra\n1\n1 2 3 4 0\nEnd\n")
run("${WORK_DIR}/mesh_file/mesh_file" "${WORK_DIR}/tet.mesh")
if(NOT output MATCHES "4 points, 1 tets, volume 0\\.167\n")
  message(FATAL_ERROR "mesh_file printed: ${output}")
endif()

# The same by pkg-config, whose file names what the static library needs.
if(pkg_config AND NOT SANITIZE)
  run(sh -c "export PKG_CONFIG_PATH='${folder}' && eval \"$1\" -std=c++20 -O1 -o \"'$3'\" \"'$2'\" \"$(pkg-config --cflags --libs palpate-io)\""
      sh "${CXX}" "${SOURCE_DIR}/examples/mesh_file/main.cpp" "${WORK_DIR}/mesh_file_by_pkg_config")
  run("${WORK_DIR}/mesh_file_by_pkg_config" "${WORK_DIR}/tet.mesh")
  if(NOT output MATCHES "4 points, 1 tets, volume 0\\.167\n")
    message(FATAL_ERROR "mesh_file, built by pkg-config, printed: ${output}")
  endif()
endif()

# Before 1.0 a minor version may change interfaces: another one is not found, and an older patch of the same is. A
# component that is not there is named in the error, with those that are.
file(STRINGS "${SOURCE_DIR}/CMakeLists.txt" version REGEX "^project\\(palpate VERSION ")
string(REGEX MATCH "([0-9]+)[.]([0-9]+)[.]([0-9]+)" version "${version}")
set(major ${CMAKE_MATCH_1})
set(minor ${CMAKE_MATCH_2})
math(EXPR next "${minor} + 1")
math(EXPR before "${minor} - 1")
# finds(EXPECTED ARGUMENTS...): what find_package(palpate ARGUMENTS) says; EXPECTED is a regular expression.
function(finds expected)
  list(JOIN ARGN " " arguments)
  file(WRITE "${WORK_DIR}/find/CMakeLists.txt" "cmake_minimum_required(VERSION 3.25)\nproject(find LANGUAGES CXX)\n"
    "find_package(palpate ${arguments})\nmessage(STATUS \"found: \${palpate_FOUND} \${palpate_NOT_FOUND_MESSAGE}\")\n")
  execute_process(COMMAND ${CMAKE_COMMAND} --fresh -S "${WORK_DIR}/find" -B "${WORK_DIR}/find/build" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${prefix}" "-DCMAKE_CXX_COMPILER=${CXX}" OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  if(NOT output MATCHES "${expected}")
    message(FATAL_ERROR "find_package(palpate ${arguments}): expected '${expected}', found: ${output}")
  endif()
endfunction()
finds("found: 1" ${major}.${minor})
finds("found: 1" ${major}.${minor}.0 EXACT COMPONENTS io)
finds("found: 0" ${major}.${before})
finds("found: 0" ${major}.${next})
finds("CMake Error.*palpate has no component 'viewer' here; components: io" REQUIRED COMPONENTS io viewer)
finds("found: 0 palpate has no component 'viewer' here; components: io" COMPONENTS viewer)
finds("found: 1" COMPONENTS io OPTIONAL_COMPONENTS viewer)

# The command's manual pages and completions lie beside it.
if(EXISTS "${prefix}/bin/palpate")
  foreach(file IN ITEMS man/man1/palpate-run.1 bash-completion/completions/palpate zsh/site-functions/_palpate
      fish/vendor_completions.d/palpate.fish)
    if(NOT EXISTS "${prefix}/share/${file}")
      message(FATAL_ERROR "share/${file} is not installed")
    endif()
  endforeach()
  # A manual page is of a program that is installed too.
  foreach(name IN ITEMS peers speed step)
    if(EXISTS "${prefix}/share/man/man1/palpate-bench-${name}.1" AND NOT EXISTS "${prefix}/bin/palpate-bench-${name}")
      message(FATAL_ERROR "the manual page of 'palpate bench ${name}' is installed without its program")
    endif()
  endforeach()
endif()
