# The images of a core. tools/firmware builds the presets and measures what comes out.
set(CMAKE_CXX_STANDARD 23)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_CXX_FLAGS_MINSIZEREL "-Oz -g -flto")
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})

add_compile_options(-Wall -Wextra -Werror -Wno-missing-field-initializers -fstack-usage -fcallgraph-info=su
  -fmacro-prefix-map=${CMAKE_SOURCE_DIR}/=)

set(lwip_parts core/def.c core/inet_chksum.c core/init.c core/ip.c core/mem.c core/memp.c core/netif.c
  core/pbuf.c core/stats.c core/tcp.c core/tcp_in.c core/tcp_out.c core/timeouts.c core/ipv4/etharp.c
  core/ipv4/icmp.c core/ipv4/ip4.c core/ipv4/ip4_addr.c netif/ethernet.c)

set(modules base wire serve)
foreach(module ${modules})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/${module}/*.cpp)
  list(APPEND slave_sources ${sources})
  list(APPEND slave_includes ${CMAKE_SOURCE_DIR}/src/${module}/include)
endforeach()
list(FILTER slave_sources EXCLUDE REGEX /frame_words.cpp$)  # for programs with text

add_library(takt_slave STATIC ${slave_sources} retained_registers.cpp serial_device.cpp slave_frame.cpp)
target_include_directories(takt_slave PUBLIC ${slave_includes} include)

# without the part that makes tables
set(table_sources answers bytes choice executor modify owen_expand owen_view rules view item_words)
list(TRANSFORM table_sources PREPEND ${CMAKE_SOURCE_DIR}/src/table/)
list(TRANSFORM table_sources APPEND .cpp)
file(GLOB bus_sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/bus/*.cpp)
add_library(takt_master STATIC EXCLUDE_FROM_ALL ${bus_sources} ${table_sources} engine_port.cpp
  table_store.cpp)
target_include_directories(takt_master PUBLIC ${CMAKE_SOURCE_DIR}/src/bus/include
  ${CMAKE_SOURCE_DIR}/src/table/include)
target_link_libraries(takt_master PUBLIC takt_slave)

# takt_image(NAME BOARD SOURCE...): NAME.elf for a folder of boards/
function(takt_image name board)
  add_executable(${name} startup.cpp boards/${board}/board.cpp ${ARGN})
  target_link_libraries(${name} PRIVATE takt_slave)
  target_link_options(${name} PRIVATE -fstack-usage -fcallgraph-info=su -flto-partition=one
    -nostartfiles -specs=nano.specs -Wl,--gc-sections
    -Wl,-Map=${CMAKE_BINARY_DIR}/${name}.map
    -L${CMAKE_CURRENT_SOURCE_DIR} -T ${CMAKE_CURRENT_SOURCE_DIR}/boards/${board}/memory.ld)
  set_target_properties(${name} PROPERTIES SUFFIX .elf UNITY_BUILD OFF LINK_DEPENDS
    "${CMAKE_CURRENT_SOURCE_DIR}/sections.ld;${CMAKE_CURRENT_SOURCE_DIR}/boards/${board}/memory.ld")
endfunction()

# takt_slave_image(BOARD NAME FRAMING BAUD STRICT [SILENCE]); the silence that ends a frame in microseconds
function(takt_slave_image board name framing baud strict)
  set(silence 0 ${ARGN})
  list(GET silence -1 silence)
  takt_image(${board}_${name} ${board} images/slave.cpp)
  target_compile_definitions(${board}_${name} PRIVATE
    TAKT_FRAMING=${framing} TAKT_BAUD=${baud} TAKT_STRICT=${strict}
    TAKT_SILENCE=${silence})
endfunction()

# takt_instrument_image(NAME SILENCE CONVERSION MOST_AGE) on microbit; microseconds
function(takt_instrument_image name silence conversion most_age)
  takt_image(microbit_${name} microbit images/instrument.cpp)
  target_compile_definitions(microbit_${name} PRIVATE TAKT_SILENCE=${silence}
    TAKT_CONVERSION=${conversion} TAKT_MOST_AGE=${most_age})
endfunction()

# takt_tcp_image(BOARD NAME IDLE KEEP_ALIVE): times as literals of std::chrono
function(takt_tcp_image board name idle keep_alive)
  takt_image(${board}_${name} ${board} images/tcp_slave.cpp boards/${board}/ethernet.cpp tcp_device.cpp)
  target_include_directories(${board}_${name} PRIVATE lwip ${lwip}/include)
  target_link_libraries(${board}_${name} PRIVATE takt_lwip)
  target_compile_definitions(${board}_${name} PRIVATE TAKT_IDLE=${idle} TAKT_KEEP_ALIVE=${keep_alive})
endfunction()

if(TAKT_CPU STREQUAL "cortex-m0")
  set(boards microbit)
elseif(TAKT_CPU STREQUAL "cortex-m3")
  set(boards mps2 lm3s6965)
else()
  set(boards mps2 stm32f407)
endif()
foreach(board ${boards})
  takt_slave_image(${board} rtu rtu 9600 false)
  takt_slave_image(${board} ascii ascii 9600 false)
  takt_slave_image(${board} test_rtu rtu 9600 false 100000)  # the host delivers characters late
endforeach()

# Slaves on Ethernet, with lwIP
if(mps2 IN_LIST boards)
  execute_process(COMMAND ${CMAKE_SOURCE_DIR}/tools/lwip --path OUTPUT_VARIABLE lwip ERROR_VARIABLE problem
    RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(failed)
    message(FATAL_ERROR "${problem}")
  endif()
  set(lwip ${lwip}/src)
  enable_language(C)
  set(CMAKE_C_FLAGS_MINSIZEREL "${CMAKE_CXX_FLAGS_MINSIZEREL}")
  list(TRANSFORM lwip_parts PREPEND ${lwip}/)
  add_library(takt_lwip STATIC ${lwip_parts})
  target_include_directories(takt_lwip PRIVATE lwip ${lwip}/include)
  set_target_properties(takt_lwip PROPERTIES UNITY_BUILD OFF)
  takt_tcp_image(mps2 tcp 10min 10s)
  takt_tcp_image(mps2 test_tcp 4s 1s)  # the tests wait for both
endif()

# takt_controller_image(NAME SILENCE): the silence that ends a frame of the slave in microseconds
function(takt_controller_image name silence)
  takt_image(mps2_${name} mps2 images/controller.cpp)
  target_link_libraries(mps2_${name} PRIVATE takt_master)
  target_compile_definitions(mps2_${name} PRIVATE TAKT_SILENCE=${silence})
endfunction()
if(mps2 IN_LIST boards)
  takt_controller_image(controller 0)
  takt_controller_image(test_controller 100000)  # the host delivers characters late
endif()

if(TAKT_CPU STREQUAL "cortex-m0")
  takt_instrument_image(instrument 0 20000 5000000)
  takt_instrument_image(test_instrument 100000 400000 1000000)
endif()

# Images of the tests
if(TAKT_CPU STREQUAL "cortex-m0")
  takt_image(microbit_test_resets microbit images/resets.cpp)
  takt_image(microbit_test_silences microbit images/silences.cpp)
else()
  takt_image(mps2_test_master mps2 images/table_master.cpp)
  target_link_libraries(mps2_test_master PRIVATE takt_master)
endif()
