# One module: a folder of src/, a namespace, a target takt::<module>, a test executable, a log category.
#
#   takt_module(<name>
#     SOURCES [<batch>: <cpp...>]...  its own sources
#     HEADERS <hpp...>        its public headers, below include/
#     LIBRARIES <target...>   libraries whose only home this module is (PRIVATE)
#     TESTS <cpp...>          tests, below test/
#     ALL_SANITIZERS          the tests instantiate what the headers define: compile them with the
#                             flags of the module
#     TEST_MODULES <name...>) modules that only the tests use
#
# The compiler reads the sources of a batch as one file (a unity build), because most of its time goes to
# headers and to the same templates. A batch is one part of the module; all of `plan` in one needs 1.2 GB of
# memory. Where the module has a folder of the batch's name, its sources are there, and private headers are
# included as "<folder>/<name>.hpp".
# Each source still includes what it uses and compiles alone: `./dev check` builds without batches.
# Names in anonymous namespaces are therefore unique in a module.
#
# src/modules.json lists the modules and what each may include; the links follow that table (PUBLIC: what an
# included module may include is allowed too). A module that is "bare" there is also compiled without
# exceptions and RTTI, and a test rejects the heap's symbols in it. A "hot" one is compiled for speed.

set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/modules.json)
file(READ ${CMAKE_SOURCE_DIR}/src/modules.json TAKT_MODULE_TABLE)

# takt_json_list(<variable> <path in the table...>): the strings of an array there, empty without one.
function(takt_json_list variable)
  set(items)
  string(JSON count ERROR_VARIABLE missing LENGTH "${TAKT_MODULE_TABLE}" modules ${ARGN})
  if(NOT missing AND count GREATER 0)
    math(EXPR last "${count} - 1")
    foreach(index RANGE ${last})
      string(JSON item GET "${TAKT_MODULE_TABLE}" modules ${ARGN} ${index})
      list(APPEND items ${item})
    endforeach()
  endif()
  set(${variable} ${items} PARENT_SCOPE)
endfunction()

# TAKT_MODULES: the names of the modules whose folder exists, in the order of the table; TAKT_UNITS: their
# parts also.
set(TAKT_MODULES)
set(TAKT_UNITS)
string(JSON module_count LENGTH "${TAKT_MODULE_TABLE}" modules)
math(EXPR last_module "${module_count} - 1")
foreach(index RANGE ${last_module})
  string(JSON module MEMBER "${TAKT_MODULE_TABLE}" modules ${index})
  if(EXISTS ${CMAKE_SOURCE_DIR}/src/${module}/CMakeLists.txt)
    list(APPEND TAKT_MODULES ${module})
    list(APPEND TAKT_UNITS ${module})
    string(JSON part_count ERROR_VARIABLE missing LENGTH "${TAKT_MODULE_TABLE}" modules ${module} parts)
    if(NOT missing)
      math(EXPR last_part "${part_count} - 1")
      foreach(part_index RANGE ${last_part})
        string(JSON part MEMBER "${TAKT_MODULE_TABLE}" modules ${module} parts ${part_index})
        list(APPEND TAKT_UNITS ${module}_${part})
      endforeach()
    endif()
  endif()
endforeach()

# takt_edges(<variable> <name> [PART <part>]): the existing modules and parts that this one may include
# directly.
function(takt_edges variable module)
  cmake_parse_arguments(ARG "" "PART" "" ${ARGN})
  set(entry ${module})
  if(ARG_PART)
    list(APPEND entry parts ${ARG_PART})
  endif()
  string(JSON includes GET "${TAKT_MODULE_TABLE}" modules ${entry} includes)
  if(includes STREQUAL "everything")
    set(edges ${TAKT_UNITS})
    list(REMOVE_ITEM edges ${module})
  else()
    takt_json_list(listed ${entry} includes)
    set(edges)
    foreach(edge ${listed})
      if(edge IN_LIST TAKT_UNITS)
        list(APPEND edges ${edge})
      endif()
    endforeach()
  endif()
  set(${variable} ${edges} PARENT_SCOPE)
endfunction()

add_library(takt_options INTERFACE)
target_compile_features(takt_options INTERFACE cxx_std_23)
target_compile_options(takt_options INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow
                       -Wno-missing-field-initializers $<$<BOOL:${TAKT_WERROR}>:-Werror>)
# In optimised code GCC 12 warns of its own library headers (GCC bugs 105651, 105562). Sanitizers and
# clang-tidy look for the same mistakes without the false alarms.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(takt_options INTERFACE
    "$<$<CONFIG:Release>:-Wno-maybe-uninitialized;-Wno-restrict;-Wno-array-bounds;-Wno-stringop-overflow>")
endif()
# Clang warns of std::get_temporary_buffer inside std::stable_sort of libstdc++ 12.
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  target_compile_options(takt_options INTERFACE -Wno-deprecated-declarations)
endif()
if(TAKT_SANITIZE)
  target_compile_options(takt_options INTERFACE -fsanitize=${TAKT_SANITIZE} -fno-sanitize-recover=all
                         -fno-omit-frame-pointer)
  target_link_options(takt_options INTERFACE -fsanitize=${TAKT_SANITIZE})
endif()

if(TAKT_FUZZ)
  target_compile_options(takt_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Further options for the code of tests.
add_library(takt_test_options INTERFACE)
target_compile_options(takt_test_options INTERFACE ${TAKT_TEST_FLAGS})

# Further options of hot modules in a release.
add_library(takt_hot_options INTERFACE)
target_compile_options(takt_hot_options INTERFACE -O2)

# The flags of code for microcontrollers.
add_library(takt_bare_options INTERFACE)
target_compile_features(takt_bare_options INTERFACE cxx_std_23)
target_compile_options(takt_bare_options INTERFACE -fno-exceptions -fno-rtti -O2)

if(TAKT_PCH)
  takt_pch(core takt_options)
  takt_pch(shell takt_options)
  takt_pch(text takt_options fmt::fmt)
  takt_pch(hot takt_options takt_hot_options)
  if(TAKT_TESTS)
    takt_pch(test takt_options takt_test_options GTest::gtest)
    takt_pch(bare takt_bare_options)
  endif()
endif()

# takt_batches(<variable> <target> <sources>): the sources without the names of the batches; `target` builds
# each batch as one file.
function(takt_batches variable target)
  set(batch ${target})
  set(sources)
  foreach(source ${ARGN})
    if(source MATCHES "^([a-z_]+):$")
      set(batch ${CMAKE_MATCH_1})
    else()
      if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/${batch})
        set(source ${batch}/${source})
      endif()
      list(APPEND sources ${source})
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${batch})
    endif()
  endforeach()
  set(${variable} ${sources} PARENT_SCOPE)
endfunction()

function(takt_module name)
  cmake_parse_arguments(MODULE "ALL_SANITIZERS" "" "SOURCES;HEADERS;LIBRARIES;TESTS;TEST_MODULES" ${ARGN})
  if(NOT name IN_LIST TAKT_MODULES)
    message(FATAL_ERROR "src/modules.json has no module '${name}'")
  endif()
  takt_edges(edges ${name})
  takt_json_list(libraries ${name} libraries)
  string(JSON hot ERROR_VARIABLE missing GET "${TAKT_MODULE_TABLE}" modules ${name} hot)
  string(JSON pure ERROR_VARIABLE missing GET "${TAKT_MODULE_TABLE}" modules ${name} pure)
  takt_unit(${name} ${edges})
  string(JSON bare ERROR_VARIABLE missing GET "${TAKT_MODULE_TABLE}" modules ${name} bare)
  if(bare STREQUAL "ON" AND TAKT_TESTS)
    takt_bare_check(${name} "${edges}")
  endif()
endfunction()

# A part of a module that needs more than its module may include: a target takt::<module>_<part> beside it.
#   takt_module_part(<module> <part> SOURCES HEADERS LIBRARIES TESTS TEST_MODULES)  as above
function(takt_module_part module part)
  cmake_parse_arguments(MODULE "" "" "SOURCES;HEADERS;LIBRARIES;TESTS;TEST_MODULES" ${ARGN})
  takt_edges(edges ${module} PART ${part})
  takt_json_list(libraries ${module} parts ${part} libraries)
  string(JSON pure ERROR_VARIABLE missing GET "${TAKT_MODULE_TABLE}" modules ${module} pure)
  string(JSON hot ERROR_VARIABLE missing GET "${TAKT_MODULE_TABLE}" modules ${module} parts ${part} hot)
  takt_unit(${module}_${part} ${module} ${edges})
endfunction()

# The target of a module or part; its arguments are in MODULE_*, `libraries`, `hot` and `pure` of the
# caller, the edges in ARGN.
function(takt_unit name)
  set(target takt_${name})
  takt_batches(sources ${target} ${MODULE_SOURCES})
  add_library(${target} STATIC ${sources})
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  add_library(takt::${name} ALIAS ${target})
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${MODULE_HEADERS})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  set_target_properties(${target} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
  set(edges ${ARGN})
  list(TRANSFORM edges PREPEND takt::)
  target_link_libraries(${target} PUBLIC ${edges} PRIVATE ${MODULE_LIBRARIES} $<BUILD_INTERFACE:takt_options>)
  set(headers core)
  if(NOT pure STREQUAL "ON")
    set(headers shell)
  endif()
  if("fmt/" IN_LIST libraries)
    target_link_libraries(${target} PRIVATE fmt::fmt)
    set(headers text)
  endif()
  if(hot STREQUAL "ON" AND CMAKE_BUILD_TYPE STREQUAL "Release")
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:takt_hot_options>)
    set(headers hot)
  endif()
  takt_use_pch(${target} ${headers})
  if(MODULE_TESTS AND TAKT_TESTS)
    list(TRANSFORM MODULE_TEST_MODULES PREPEND takt::)
    set(flags)
    if(MODULE_ALL_SANITIZERS)
      set(flags ALL_SANITIZERS)
    endif()
    takt_test(${name}_test ${flags} SOURCES ${MODULE_TESTS} LIBRARIES takt::${name} ${MODULE_TEST_MODULES})
  endif()
endfunction()

# A test executable whose cases ctest runs one process for all. Its own code is compiled with
# TAKT_TEST_FLAGS, the libraries with all sanitizers. Each source has a namespace of its own, so eight at a
# time are read as one file.
function(takt_test name)
  if(NOT TARGET takt_test_skips)
    add_library(takt_test_skips OBJECT ${CMAKE_SOURCE_DIR}/tests/support/skips.cpp)
    target_link_libraries(takt_test_skips PRIVATE takt_options takt_test_options GTest::gtest)
  endif()
  cmake_parse_arguments(TEST "ALL_SANITIZERS" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 8)
  target_link_libraries(${name} PRIVATE ${TEST_LIBRARIES} takt_options ${RAPIDCHECK_LIBRARY}
    takt_test_skips GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests/support)
  foreach(source ${TEST_SOURCES})  # the private headers of each module whose tests or fixtures these are
    cmake_path(ABSOLUTE_PATH source NORMALIZE)
    if(source MATCHES "^${CMAKE_SOURCE_DIR}/src/([a-z]+)/test/")
      target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/src/${CMAKE_MATCH_1})
    endif()
  endforeach()
  target_compile_options(${name} PRIVATE -Wno-sign-conversion -Wno-conversion)
  if(TEST_ALL_SANITIZERS)
    takt_use_pch(${name} core)
  else()
    target_link_libraries(${name} PRIVATE takt_test_options)
    takt_use_pch(${name} test)
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 600 PROCESSORS 2)
endfunction()

# The module once more as for a microcontroller: no exceptions, no RTTI, and no heap in its symbols.
function(takt_bare_check name edges)
  set(target takt_${name}_bare)
  get_target_property(sources takt_${name} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  add_library(${target} OBJECT ${sources})
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  target_include_directories(${target} PRIVATE include ${CMAKE_CURRENT_SOURCE_DIR})
  foreach(edge ${edges})
    target_include_directories(${target} PRIVATE
      $<TARGET_PROPERTY:takt::${edge},INTERFACE_INCLUDE_DIRECTORIES>)
  endforeach()
  target_link_libraries(${target} PRIVATE takt_bare_options)
  takt_use_pch(${target} bare)
  add_test(NAME ${name}_has_no_heap
           COMMAND ${CMAKE_SOURCE_DIR}/tools/check_symbols ${CMAKE_NM} $<TARGET_OBJECTS:${target}>
           COMMAND_EXPAND_LISTS)
endfunction()
