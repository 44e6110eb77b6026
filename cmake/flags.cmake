# One interface target carries the flags of our own code; it is never exported.
add_library(palpate_flags INTERFACE)
target_compile_options(palpate_flags INTERFACE
  -Wall -Wextra -Wconversion $<$<BOOL:${PALPATE_WERROR}>:-Werror>
  # Where files are compiled together, the constants of one are no business of another; clang cannot tell them apart.
  $<IF:$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>,$<$<CXX_COMPILER_ID:GNU>:-Wshadow=local>,-Wshadow>
  # The same bits everywhere: the compiler must not fuse a*b+c where the source does not say so.
  -ffp-contract=off)
if(PALPATE_SANITIZE)
  add_compile_options(-fsanitize=${PALPATE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${PALPATE_SANITIZE})
endif()

# For folders whose speed does not matter: in tests, the command and the server, the last level of optimisation takes up
# to a third of the time of a compilation, and the one before it a quarter of what is left. A number is that of -O.
macro(palpate_optimise_less level)
  string(REPLACE "-O3" "-O${level}" CMAKE_CXX_FLAGS_RELEASE "${CMAKE_CXX_FLAGS_RELEASE}")
endmacro()
