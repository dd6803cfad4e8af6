# One room: a folder of src/, a namespace, a target takt::<room>, a test executable, a log category (design, section 1).
#
#   takt_room(<name> [BARE] [INTERFACE]
#     SOURCES <cpp...>        its own sources
#     HEADERS <hpp...>        its public headers, below include/
#     ROOMS <room...>         the rooms it may include (PUBLIC links: what they may include is allowed too)
#     LIBRARIES <target...>   libraries whose only home this room is (PRIVATE)
#     TESTS <cpp...>)         tests, below test/
#
# BARE: the room is also compiled without exceptions and RTTI, and a test refuses the heap's symbols in it.

add_library(takt_options INTERFACE)
target_compile_features(takt_options INTERFACE cxx_std_23)
target_compile_options(takt_options INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow
                       -Wno-missing-field-initializers $<$<BOOL:${TAKT_WERROR}>:-Werror>)
if(TAKT_SANITIZE)
  target_compile_options(takt_options INTERFACE -fsanitize=${TAKT_SANITIZE} -fno-sanitize-recover=all
                         -fno-omit-frame-pointer)
  target_link_options(takt_options INTERFACE -fsanitize=${TAKT_SANITIZE})
endif()

if(TAKT_FUZZ)
  target_compile_options(takt_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

function(takt_room name)
  cmake_parse_arguments(ROOM "BARE" "" "SOURCES;HEADERS;ROOMS;LIBRARIES;TESTS" ${ARGN})
  set(target takt_${name})
  add_library(${target} STATIC ${ROOM_SOURCES})
  add_library(takt::${name} ALIAS ${target})
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${ROOM_HEADERS})
  set_target_properties(${target} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
  list(TRANSFORM ROOM_ROOMS PREPEND takt::)
  target_link_libraries(${target} PUBLIC ${ROOM_ROOMS} PRIVATE ${ROOM_LIBRARIES} $<BUILD_INTERFACE:takt_options>)
  if(ROOM_TESTS AND TAKT_TESTS)
    takt_test(${name}_test SOURCES ${ROOM_TESTS} LIBRARIES takt::${name})
  endif()
  if(ROOM_BARE AND TAKT_TESTS)
    takt_bare_check(${name} "${ROOM_SOURCES}" "${ROOM_ROOMS}")
  endif()
endfunction()

# A part of a room that needs more than its room may: a target takt::<room>_<part> beside it.
#   takt_room_part(<room> <part> SOURCES HEADERS ROOMS LIBRARIES TESTS)  as above; ROOMS beside its own
function(takt_room_part room part)
  cmake_parse_arguments(PART "" "" "SOURCES;HEADERS;ROOMS;LIBRARIES;TESTS" ${ARGN})
  takt_room(${room}_${part} SOURCES ${PART_SOURCES} HEADERS ${PART_HEADERS} ROOMS ${room} ${PART_ROOMS}
            LIBRARIES ${PART_LIBRARIES} TESTS ${PART_TESTS})
endfunction()

# A test executable whose cases ctest runs one process for all.
function(takt_test name)
  cmake_parse_arguments(TEST "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE ${TEST_LIBRARIES} takt_options ${RAPIDCHECK_LIBRARY} GTest::gtest_main)
  target_compile_options(${name} PRIVATE -Wno-sign-conversion -Wno-conversion)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 120)
endfunction()

# The room once more as for a microcontroller: no exceptions, no RTTI, and no heap in its symbols.
function(takt_bare_check name sources rooms)
  set(target takt_${name}_bare)
  add_library(${target} OBJECT ${sources})
  target_include_directories(${target} PRIVATE include)
  foreach(room ${rooms})
    target_include_directories(${target} PRIVATE $<TARGET_PROPERTY:${room},INTERFACE_INCLUDE_DIRECTORIES>)
  endforeach()
  target_compile_features(${target} PRIVATE cxx_std_23)
  target_compile_options(${target} PRIVATE -fno-exceptions -fno-rtti -O2)
  add_test(NAME ${name}_has_no_heap
           COMMAND ${CMAKE_SOURCE_DIR}/tools/check_symbols ${CMAKE_NM} $<TARGET_OBJECTS:${target}>
           COMMAND_EXPAND_LISTS)
endfunction()
