# Installs BUILD_DIR below WORK_DIR, checks each installed header, then builds and runs examples/embed against it.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "exit ${result} from: ${command}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

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

# The boxes overlap by 0.1 along z and by 0.7 along x and y: 0.1 deep, straight up, but for what the planes of the sides add.
if(NOT output MATCHES "point 8 is 0\\.1[01][0-9] deep in body 0, out: \\(0\\.0[0-9], 0\\.0[0-9], 1\\.00\\)\n")
  message(FATAL_ERROR "embed printed: ${output}")
endif()
