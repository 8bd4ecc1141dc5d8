// An OBJ file; what follows a line "====" is its material library.
#include "fuzz/document.h"
#include "mq/io/detail/obj.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace mq;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t cut = std::min(text.find("\n====\n"), text.size());
  auto document = std::make_shared<Document>();
  document->format = Document::Format::obj;
  document->name = "fuzz.obj";
  document->bytes = to_bytes(text.substr(0, cut));
  if (cut < text.size()) document->parts = {{"fuzz.mtl", to_bytes(text.substr(cut + 6))}};
  fuzz_document(document, [](const Model& model, const std::vector<std::string>& pictures) {
    return write_obj(model, pictures, "fuzz").files;
  });
  return 0;
}
