# shareable(TARGET...): these static libraries can be linked into shared ones, such as the Python module. Hidden
# symbols are called directly, so programs are no slower for it.
function(shareable)
  set_target_properties(${ARGN} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden)
endfunction()
