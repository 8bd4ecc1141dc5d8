#include "fuzz/document.h"
#include "mq/io/detail/ply.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace mq;
  auto document = std::make_shared<Document>();
  document->format = Document::Format::ply;
  document->name = "fuzz.ply";
  document->bytes = to_bytes({reinterpret_cast<const char*>(data), size});
  fuzz_document(document, [](const Model& model, const std::vector<std::string>& pictures) {
    return std::vector<OutputFile>{write_ply(model, pictures, "fuzz")};
  });
  return 0;
}
