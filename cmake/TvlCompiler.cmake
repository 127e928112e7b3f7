# Compiler settings shared by every target.
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
find_program(TVL_CCACHE ccache)
if(TVL_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TVL_CCACHE})
endif()

add_library(tvl_compiler INTERFACE)
target_compile_options(tvl_compiler INTERFACE -Wall -Wextra -Wconversion -Wshadow
                       # No fused or reassociated arithmetic: results must not depend on inlining.
                       -ffp-contract=off)
if(TVL_WARNINGS_AS_ERRORS)
  target_compile_options(tvl_compiler INTERFACE -Werror)
endif()
if(TVL_SANITIZE)
  target_compile_options(tvl_compiler INTERFACE -fsanitize=${TVL_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(tvl_compiler INTERFACE -fsanitize=${TVL_SANITIZE})
endif()
