// A package of USD where it begins like one, USD where it begins with "#", a GLB or glTF otherwise: frames of vertices
// as many as their segments have, or an error of ours.
#include "fuzz/document.h"
#include "mq/io/detail/animation_found.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace mq;
  const Bytes bytes = to_bytes({reinterpret_cast<const char*>(data), size});
  const std::string_view text = text_of(bytes);
  try {
    const FoundAnimation found = text.starts_with("PK")  ? find_usdz_animation("fuzz.usdz", bytes)
                                 : text.starts_with("#") ? find_usda_animation("fuzz.usda", bytes)
                                                         : find_gltf_animation("fuzz.glb", bytes, "/nowhere");
    expect(found.segments.size() == found.pictures.size() && found.numbers.size() == found.segment_of.size());
    for (std::size_t f = 0; f < found.segment_of.size(); ++f) {
      expect(found.segment_of[f] >= 0 && found.segment_of[f] < int(found.segments.size()));
      expect(f == 0 || found.numbers[f] > found.numbers[f - 1]);
      const EvolvingSegment& segment = found.segments[std::size_t(found.segment_of[f])];
      for (const Triangle& t : segment.triangles)
        for (const int v : t) expect(v >= 0 && v < segment.vertex_count());
      for (const Triangle& t : segment.corner_uvs)
        for (const int uv : t) expect(uv >= -1 && uv < int(segment.uvs.size()));
      if (f < 100) found.positions(int(f));
    }
  } catch (const Error&) {
  }
  return 0;
}
