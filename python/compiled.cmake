# Installs the package of the folder PALPATE_PYTHON_COMPILED as python/CMakeLists.txt would, without compiling it.
find_package(hwy 1.0 REQUIRED)
file(GLOB compiled ${PALPATE_PYTHON_COMPILED}/_core*.so)
if(NOT compiled)
  message(FATAL_ERROR "there is no compiled module in ${PALPATE_PYTHON_COMPILED}")
endif()
file(COPY ${compiled} DESTINATION ${PROJECT_BINARY_DIR})
get_filename_component(name ${compiled} NAME)
# What lies in a build folder looks for its libraries where the system has them.
install(PROGRAMS ${PROJECT_BINARY_DIR}/${name} DESTINATION palpate COMPONENT python)
install(FILES ${PALPATE_PYTHON_COMPILED}/_core.pyi ${PALPATE_PYTHON_COMPILED}/py.typed DESTINATION palpate COMPONENT python)
install(IMPORTED_RUNTIME_ARTIFACTS hwy::hwy LIBRARY DESTINATION palpate COMPONENT python)
add_custom_target(palpate_python)
add_custom_target(palpate_python_stub)
