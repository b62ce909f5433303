# SPDX-License-Identifier: Apache-2.0
# What makes the host's build short; the figures stand in docs/measured.md. Nothing here changes a number that a
# program computes.

# Most of a compilation is the templates of Eigen, JSON, CLI11, fmt and GoogleTest, instantiated anew in each source.
# The sources of one library are therefore compiled a few together, as if they were one file (CMake's unity build). So
# a name in an anonymous namespace occurs once in a library; what two sources need belongs into a header of theirs. An
# editor or a tool that wants a command for each source sets -DSLIPSTACK_JOIN_SOURCES=OFF.
option(SLIPSTACK_JOIN_SOURCES "Compile the sources of a library a few together" ON)
set(CMAKE_UNITY_BUILD ${SLIPSTACK_JOIN_SOURCES})
set(CMAKE_UNITY_BUILD_BATCH_SIZE 8 CACHE STRING "Sources compiled together")
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Where much is inlined GCC 12 sees overlapping copies in std::string where there are none (its bug 105651).
  add_compile_options(-Wno-unknown-warning-option -Wno-restrict)  # clang-tidy reads them too
endif()

# ccache, where it is installed.
find_program(SLIPSTACK_CCACHE ccache DOC "Compiler cache; empty for none")
if(SLIPSTACK_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_C_COMPILER_LAUNCHER ${SLIPSTACK_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SLIPSTACK_CCACHE})
endif()

# slipstack_compile_apart(TARGET...): each source by itself, where names would meet.
function(slipstack_compile_apart)
  set_target_properties(${ARGN} PROPERTIES UNITY_BUILD OFF)
endfunction()

# slipstack_compile_lightly(TARGET...): -O1 for what reads options and writes text. Not for loops over samples.
function(slipstack_compile_lightly)
  foreach(target IN LISTS ARGN)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE 12)
  endforeach()
endfunction()

# The libraries are linked into programs and into the Python module, a shared object: both take the same objects, whether
# Python is there or not, so that nothing is compiled twice. Names are hidden: those that a shared object exports could
# be replaced by another's, so that their functions would not be inlined.
macro(slipstack_compile_for_shared_objects)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
  set(CMAKE_CXX_VISIBILITY_PRESET hidden)
  set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
endmacro()
macro(slipstack_compile_for_programs)
  unset(CMAKE_POSITION_INDEPENDENT_CODE)
  unset(CMAKE_CXX_VISIBILITY_PRESET)
  unset(CMAKE_VISIBILITY_INLINES_HIDDEN)
endmacro()
