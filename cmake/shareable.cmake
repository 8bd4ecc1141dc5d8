# shareable(TARGET...): these static libraries can be linked into shared ones, such as the Python module. Hidden
# symbols are called directly: `filter` of a texture of 256² takes 1.4 % more instructions for it (callgrind).
function(shareable)
  set_target_properties(${ARGN} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden)
endfunction()
