# Precompiled headers: takt_use_pch(<target> core|shell|text|hot|test|bare). A kind is compiled once and
# shared by all its targets; it adds headers of libraries only, so that an edit recompiles what it did before.
#
# A file must not rely on them: it includes what it uses. `./dev check` builds without them (TAKT_PCH=OFF).

# takt_pch(<kind> <libraries that give the flags...>)
function(takt_pch kind)
  set(header ${kind})
  if(kind MATCHES "^(bare|hot)$")
    set(header core)
  endif()
  set(target takt_pch_${kind})
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${CMAKE_SOURCE_DIR}/cmake/pch/empty.cpp)
  target_precompile_headers(${target} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/pch/${header}.hpp)
  target_link_libraries(${target} PRIVATE ${ARGN})
endfunction()

function(takt_use_pch target kind)
  if(TAKT_PCH)
    target_precompile_headers(${target} REUSE_FROM takt_pch_${kind})
  endif()
endfunction()
