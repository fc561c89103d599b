// A tiny ONNX file written byte by byte (protocol buffers, onnx.proto): one 1x1 convolution and a sigmoid.
#pragma once

#include <cstring>
#include <string>
#include <vector>

namespace ohb {

class Protobuf {
 public:
  Protobuf& number(int field, uint64_t value) {
    varint(static_cast<uint64_t>(field) << 3);
    varint(value);
    return *this;
  }
  Protobuf& bytes(int field, const std::string& value) {
    varint(static_cast<uint64_t>(field) << 3 | 2);
    varint(value.size());
    data_ += value;
    return *this;
  }
  const std::string& data() const { return data_; }

 private:
  void varint(uint64_t value) {
    for (; value >= 128; value >>= 7) data_ += static_cast<char>((value & 127) | 128);
    data_ += static_cast<char>(value);
  }
  std::string data_;
};

inline std::string onnx_floats(const std::string& name, const std::vector<int>& dims,
                               const std::vector<float>& values) {
  Protobuf tensor;
  for (const int d : dims) tensor.number(1, static_cast<uint64_t>(d));
  std::string raw(values.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), values.data(), raw.size());
  return tensor.number(2, 1).bytes(8, name).bytes(9, raw).data();
}

inline std::string onnx_value(const std::string& name, const std::vector<int>& dims) {
  Protobuf shape;
  for (const int d : dims) shape.bytes(1, Protobuf().number(1, static_cast<uint64_t>(d)).data());
  const std::string tensor = Protobuf().number(1, 1).bytes(2, shape.data()).data();
  return Protobuf().bytes(1, name).bytes(2, Protobuf().bytes(1, tensor).data()).data();
}

/// sigmoid(red * weights[0] + green * weights[1] + blue * weights[2] + bias) of `channels_out` equal planes,
/// 256 x 256.
inline std::string colour_network(const std::vector<float>& weights, float bias, int channels_out = 1) {
  std::vector<float> all, biases(static_cast<size_t>(channels_out), bias);
  for (int i = 0; i < channels_out; ++i) all.insert(all.end(), weights.begin(), weights.end());
  const std::string kernel =
      Protobuf().bytes(1, "kernel_shape").number(8, 1).number(8, 1).number(20, 7).data();
  const std::string convolution = Protobuf()
                                      .bytes(1, "x")
                                      .bytes(1, "w")
                                      .bytes(1, "b")
                                      .bytes(2, "z")
                                      .bytes(3, "c")
                                      .bytes(4, "Conv")
                                      .bytes(5, kernel)
                                      .data();
  const std::string sigmoid = Protobuf().bytes(1, "z").bytes(2, "y").bytes(3, "s").bytes(4, "Sigmoid").data();
  const std::string graph = Protobuf()
                                .bytes(1, convolution)
                                .bytes(1, sigmoid)
                                .bytes(2, "colour")
                                .bytes(5, onnx_floats("w", {channels_out, 3, 1, 1}, all))
                                .bytes(5, onnx_floats("b", {channels_out}, biases))
                                .bytes(11, onnx_value("x", {1, 3, 256, 256}))
                                .bytes(12, onnx_value("y", {1, channels_out, 256, 256}))
                                .data();
  return Protobuf().number(1, 6).bytes(7, graph).bytes(8, Protobuf().number(2, 11).data()).data();
}

}  // namespace ohb
