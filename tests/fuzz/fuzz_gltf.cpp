// A GLB where it begins like one, a glTF otherwise.
#include "fuzz/document.h"
#include "mq/io/detail/gltf.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace mq;
  auto document = std::make_shared<Document>();
  document->name = "fuzz.gltf";
  document->bytes = to_bytes({reinterpret_cast<const char*>(data), size});
  const bool binary = text_of(document->bytes).starts_with("glTF");
  document->format = binary ? Document::Format::glb : Document::Format::gltf;
  document->parts = {{"fuzz.bin", Bytes(256)}};
  fuzz_document(document, [&](const Model& model, const std::vector<std::string>& names) {
    std::vector<GltfPicture> pictures;
    for (const std::string& name : names) pictures.push_back({name, "image/png", false, {}});
    for (GltfPicture& picture : pictures) picture.file = [] { return Bytes(); };
    return write_gltf(model, document->format, pictures, "fuzz").files;
  });
  return 0;
}
