#include "learner/networks.h"

#include <ATen/TracerMode.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "learner/conv.h"
#include "learner/norm_silu.h"

namespace ohb::learner {
namespace {

using torch::Tensor;
namespace nn = torch::nn;
namespace F = torch::nn::functional;
using Scale = ConvBlockImpl::Scale;

constexpr std::array<int64_t, 5> kEncoderWidths = {64, 128, 256, 512, 512};
constexpr std::array<int64_t, 3> kGuidanceWidths = {64, 128, 256};

nn::Conv2d conv1(int64_t in, int64_t out, bool bias) {
  return nn::Conv2d(nn::Conv2dOptions(in, out, 1).bias(bias));
}

nn::Conv2d conv3(int64_t in, int64_t out, int64_t stride, bool bias) {
  return nn::Conv2d(nn::Conv2dOptions(in, out, 3).stride(stride).padding(1).bias(bias));
}

/// At most 16 groups of at least 4 channels: a group of one channel would forget its level.
nn::GroupNorm group_norm(int64_t channels) {
  return nn::GroupNorm(nn::GroupNormOptions(std::min<int64_t>(16, channels / 4), channels));
}

/// SiLU after group norm.
Tensor activated(const Tensor& x, const nn::GroupNorm& norm) {
  return norm_silu(x, norm->options.num_groups(), norm->weight, norm->bias, norm->options.eps());
}

Tensor doubled(const Tensor& x) {
  return F::interpolate(x, F::InterpolateFuncOptions()
                               .size(std::vector<int64_t>{2 * x.size(2), 2 * x.size(3)})
                               .mode(torch::kBilinear)
                               .align_corners(false));
}

/// Maps in [0, 1] as inputs in [-1, 1]. Their background means nothing: it is set to the middle. `mask` as
/// 2x - 1.
Tensor foreground_of(const Tensor& maps, const Tensor& mask) {
  return (2 * maps - 1) * (0.5 * (mask + 1));
}

/// (B, C, h, w) to (B, h w, C).
Tensor tokens_of(const Tensor& x) {
  return x.flatten(2).transpose(1, 2).contiguous();
}

/// Sines and cosines of the row and of the column, a quarter of the channels each: (1, h w, channels). A
/// recorded network keeps them as numbers: computing them again would name this device.
Tensor positions(int64_t height, int64_t width, int64_t channels, const torch::TensorOptions& options) {
  const at::tracer::impl::NoTracerDispatchMode unrecorded;
  const int64_t quarter = channels / 4;
  const Tensor frequency =
      torch::exp(torch::arange(quarter, options) * (-std::log(1e4) / static_cast<double>(quarter)));
  const auto waves = [&](int64_t count) {
    const Tensor angle = torch::arange(count, options).unsqueeze(1) * frequency;
    return torch::cat({angle.sin(), angle.cos()}, 1);
  };
  const Tensor rows = waves(height).unsqueeze(1).expand({height, width, 2 * quarter});
  const Tensor columns = waves(width).unsqueeze(0).expand({height, width, 2 * quarter});
  return torch::cat({rows, columns}, 2).view({1, height * width, 4 * quarter});
}

void check_input(const Tensor& x, int64_t channels) {
  if (x.dim() != 4 || x.size(1) != channels || x.size(2) % kResolutionStep != 0 ||
      x.size(3) % kResolutionStep != 0 || x.size(2) == 0 || x.size(3) == 0)
    throw std::invalid_argument("network input is not (B, " + std::to_string(channels) +
                                ", H, W) with H and W multiples of 16");
}

}  // namespace

int64_t scaled_width(int64_t channels, double multiplier) {
  return 16 * std::max<int64_t>(1, std::lround(static_cast<double>(channels) * multiplier / 16));
}

ConvBlockImpl::ConvBlockImpl(int64_t in, int64_t out, Scale block_scale)
    : scale(block_scale),
      mix(register_module("mix", conv1(in, out, false))),
      conv(register_module("conv", conv3(out, out, block_scale == Scale::kDown ? 2 : 1, false))),
      norm(register_module("norm", group_norm(out))) {}

Tensor ConvBlockImpl::forward(Tensor x) {
  x = pointwise(x, mix->weight, mix->bias);
  if (scale == Scale::kUp) x = doubled(x);
  return activated(conv3x3(x, conv), norm);
}

GuidanceEncoderImpl::GuidanceEncoderImpl(int64_t in, double width) {
  for (int i = 0; i < 9; ++i) {
    channels[i / 3] = scaled_width(kGuidanceWidths[i / 3], width);
    blocks.push_back(
        register_module("block" + std::to_string(i),
                        ConvBlock(in, channels[i / 3], i % 3 == 0 ? Scale::kDown : Scale::kSame)));
    in = channels[i / 3];
  }
}

std::array<Tensor, 3> GuidanceEncoderImpl::forward(Tensor x) {
  std::array<Tensor, 3> features;
  for (int i = 0; i < 9; ++i) {
    x = blocks[i](x);
    if (i % 3 == 2) features[i / 3] = x;
  }
  return features;
}

FusionBlockImpl::FusionBlockImpl(int64_t channels, int64_t guidance_channels)
    : norm_latent_(register_module("norm_latent", nn::LayerNorm(nn::LayerNormOptions({channels})))),
      norm_guidance_(
          register_module("norm_guidance", nn::LayerNorm(nn::LayerNormOptions({guidance_channels})))),
      norm_self_(register_module("norm_self", nn::LayerNorm(nn::LayerNormOptions({channels})))),
      norm_mlp_(register_module("norm_mlp", nn::LayerNorm(nn::LayerNormOptions({channels})))),
      query_(register_module("query", nn::Linear(channels, channels))),
      key_(register_module("key", nn::Linear(guidance_channels, channels))),
      value_(register_module("value", nn::Linear(guidance_channels, channels))),
      cross_out_(register_module("cross_out", nn::Linear(channels, channels))),
      self_in_(register_module("self_in", nn::Linear(channels, 3 * channels))),
      self_out_(register_module("self_out", nn::Linear(channels, channels))),
      mlp_in_(register_module("mlp_in", nn::Linear(channels, 4 * channels))),
      mlp_out_(register_module("mlp_out", nn::Linear(4 * channels, channels))) {}

Tensor FusionBlockImpl::attend(const Tensor& queries, const Tensor& keys, const Tensor& values) {
  // Sizes of the batch are left open, so that a recorded network (torchscript.h) takes any.
  const int64_t channels = queries.size(2), each = channels / kHeads;
  const auto heads = [&](const Tensor& x) {
    return x.view({-1, x.size(1), kHeads, each}).transpose(1, 2).reshape({-1, x.size(1), each});
  };
  const Tensor scores =
      torch::bmm(heads(queries) * (1 / std::sqrt(static_cast<double>(each))), heads(keys).transpose(1, 2));
  const Tensor mixed = torch::bmm(torch::softmax(scores, -1), heads(values));
  return mixed.view({-1, kHeads, queries.size(1), each})
      .transpose(1, 2)
      .reshape({-1, queries.size(1), channels});
}

Tensor FusionBlockImpl::forward(const Tensor& latent, const std::vector<Tensor>& guidance) {
  const int64_t channels = latent.size(1), height = latent.size(2), width = latent.size(3);
  std::vector<Tensor> hints;
  for (const Tensor& features : guidance) {
    const Tensor tokens = norm_guidance_(tokens_of(torch::avg_pool2d(features, 2)));
    hints.push_back(tokens + positions(height, width, tokens.size(2), tokens.options()));
  }
  const Tensor hint = torch::cat(hints, 1);
  Tensor x = tokens_of(latent);
  x = x + positions(height, width, channels, x.options());
  x = x + cross_out_(attend(query_(norm_latent_(x)), key_(hint), value_(hint)));
  const std::vector<Tensor> parts = self_in_(norm_self_(x)).chunk(3, 2);
  x = x + self_out_(attend(parts[0].contiguous(), parts[1].contiguous(), parts[2].contiguous()));
  x = x + mlp_out_(torch::gelu(mlp_in_(norm_mlp_(x))));
  return x.view({-1, height, width, channels}).permute({0, 3, 1, 2});  // channels last
}

LatentEncoderImpl::LatentEncoderImpl(int64_t in, double width) {
  stem = register_module("stem", conv1(in, scaled_width(kEncoderWidths[0], width), true));
  for (int i = 0; i < 4; ++i)
    down[i] = register_module("down" + std::to_string(i),
                              ConvBlock(scaled_width(kEncoderWidths[i], width),
                                        scaled_width(kEncoderWidths[i + 1], width), Scale::kDown));
}

std::array<Tensor, 5> LatentEncoderImpl::forward(const Tensor& x) {
  std::array<Tensor, 5> features;
  features[0] = pointwise(x, stem->weight, stem->bias);
  for (int i = 0; i < 4; ++i) features[i + 1] = down[i](features[i]);
  return features;
}

DecoderImpl::DecoderImpl(int64_t out, double width) {
  // Up block i puts out 512 @1/8, 256 @1/4, 128 @1/2, 64 @1: the widths of the encoder at these scales.
  int64_t in = scaled_width(kEncoderWidths[4], width);
  for (int i = 0; i < 4; ++i) {
    const int64_t channels = scaled_width(kEncoderWidths[3 - i], width);
    up[i] = register_module("up" + std::to_string(i), ConvBlock(in, channels, Scale::kUp));
    in = 2 * channels + (i < 3 ? scaled_width(kGuidanceWidths[2 - i], width) : 0);
  }
  const int64_t channels = scaled_width(kEncoderWidths[0], width);
  merge = register_module("merge", conv1(in, channels, true));
  for (int i = 0; i < 6; ++i)
    refine[i] = register_module("refine" + std::to_string(i), conv3(channels, channels, 1, true));
  hidden = register_module("hidden", conv1(channels, channels, true));
  output = register_module("output", conv1(channels, out, true));
}

Tensor DecoderImpl::forward(Tensor x, const std::array<Tensor, 5>& skips,
                            const std::array<Tensor, 3>& guidance) {
  for (int i = 0; i < 4; ++i) {
    x = up[i](x);
    x = i < 3 ? torch::cat({x, skips[3 - i], guidance[2 - i]}, 1) : torch::cat({x, skips[0]}, 1);
  }
  x = pointwise(x, merge->weight, merge->bias);
  for (int i = 0; i < 6; i += 2) x = x + conv3x3(torch::silu(conv3x3(x, refine[i])), refine[i + 1]);
  x = torch::silu(pointwise(x, hidden->weight, hidden->bias));
  return pointwise(x, output->weight, output->bias);
}

PriorNetImpl::PriorNetImpl(int64_t out, double width)
    : encoder(register_module("encoder", LatentEncoder(4, width))),
      guidance(register_module("guidance", GuidanceEncoder(4, width))),
      fusion(register_module("fusion", FusionBlock(scaled_width(kEncoderWidths[4], width),
                                                   scaled_width(kGuidanceWidths[2], width)))),
      decoder(register_module("decoder", Decoder(out, width))) {}

Tensor PriorNetImpl::forward(Tensor input) {
  check_input(input, 4);
  input = input.contiguous(torch::MemoryFormat::ChannelsLast);
  const std::array<Tensor, 5> features = encoder(input);
  const std::array<Tensor, 3> hints = guidance(input);
  return torch::sigmoid(decoder(fusion(features[4], std::vector<Tensor>{hints[2]}), features, hints));
}

FinetuneNetImpl::FinetuneNetImpl(double width)
    : encoder(register_module("encoder", LatentEncoder(4, width))),
      fusion(register_module("fusion", FusionBlock(scaled_width(kEncoderWidths[4], width),
                                                   scaled_width(kGuidanceWidths[2], width)))) {
  for (size_t i = 0; i < kChannels.size(); ++i) {
    // Each guidance comes with the mask.
    guidance[i] =
        register_module(std::string("guidance_") + kNames[i], GuidanceEncoder(kChannels[i] + 1, width));
    decoders[i] = register_module(std::string("decoder_") + kNames[i], Decoder(kChannels[i], width));
  }
}

Tensor FinetuneNetImpl::forward(Tensor input, const Tensor& maps) {
  check_input(input, 4);
  check_input(maps, 7 + rss_channels());
  input = input.contiguous(torch::MemoryFormat::ChannelsLast);
  const Tensor mask = input.slice(1, 3, 4);
  const Tensor signed_maps = foreground_of(maps, mask).contiguous(torch::MemoryFormat::ChannelsLast);
  const std::array<Tensor, 5> features = encoder(input);
  std::array<std::array<Tensor, 3>, 4> hints;
  std::vector<Tensor> tokens;
  int64_t first = 0;
  for (size_t i = 0; i < kChannels.size(); ++i) {
    hints[i] = guidance[i](torch::cat({signed_maps.slice(1, first, first + kChannels[i]), mask}, 1));
    tokens.push_back(hints[i][2]);
    first += kChannels[i];
  }
  const Tensor latent = fusion(features[4], tokens);
  std::vector<Tensor> outputs;
  for (size_t i = 0; i < kChannels.size(); ++i) outputs.push_back(decoders[i](latent, features, hints[i]));
  return torch::sigmoid(torch::cat(outputs, 1));
}

ResidualBlockImpl::ResidualBlockImpl(int64_t channels) {
  for (size_t i = 0; i < 2; ++i) {
    norm[i] = register_module("norm" + std::to_string(i), group_norm(channels));
    conv[i] = register_module("conv" + std::to_string(i), conv3(channels, channels, 1, i == 1));
  }
}

Tensor ResidualBlockImpl::forward(const Tensor& x) {
  Tensor change = x;
  for (size_t i = 0; i < 2; ++i) change = conv3x3(activated(change, norm[i]), conv[i]);
  return x + change;
}

JointNetImpl::JointNetImpl(int64_t out, double width, bool takes_maps) : refines(takes_maps) {
  const int64_t gathered = 4 * (4 + (refines ? out : 0));
  std::array<int64_t, 4> channels;
  for (size_t i = 0; i < 4; ++i) channels[i] = scaled_width(kWidths[i], width);
  const auto add_blocks = [&](const std::string& side, size_t level, int count) {
    std::vector<ResidualBlock> blocks;
    blocks.reserve(static_cast<size_t>(count));
    for (int k = 0; k < count; ++k)
      blocks.push_back(register_module(side + std::to_string(level) + "_block" + std::to_string(k),
                                       ResidualBlock(channels[level])));
    return blocks;
  };
  stem = register_module("stem", conv1(gathered, channels[0], true));
  for (size_t i = 0; i < 4; ++i) {
    blocks_down[i] = add_blocks("down", i, kBlocksDown[i]);
    blocks_up[i] = add_blocks("up", i, kBlocksUp[i]);
    if (i == 3) break;
    down[i] = register_module("down" + std::to_string(i), conv3(channels[i], channels[i + 1], 2, true));
    up[i] = register_module("up" + std::to_string(i), conv1(channels[i + 1], channels[i], true));
  }
  fusion = register_module("fusion", FusionBlock(channels[3], channels[2]));
  norm = register_module("norm", group_norm(channels[0]));
  head = register_module("head", conv1(channels[0] + gathered, 4 * out, true));
  if (!refines) return;
  const torch::NoGradGuard no_gradients;
  head->weight.zero_();
  head->bias.zero_();
}

Tensor JointNetImpl::forward(Tensor input, const Tensor& maps) {
  check_input(input, 4);
  if (refines) {
    check_input(maps, head->options.out_channels() / 4);
    input = torch::cat({input, foreground_of(maps, input.slice(1, 3, 4))}, 1);
  }
  input = torch::pixel_unshuffle(input, 2).contiguous(torch::MemoryFormat::ChannelsLast);
  std::array<Tensor, 4> features;
  Tensor x = pointwise(input, stem->weight, stem->bias);
  for (size_t i = 0; i < 4; ++i) {
    if (i > 0) x = conv3x3(x, down[i - 1]);
    for (ResidualBlock& block : blocks_down[i]) x = block(x);
    features[i] = x;
  }
  x = fusion(x, std::vector<Tensor>{features[2]});
  for (size_t i = 4; i-- > 0;) {
    if (i < 3) x = features[i] + doubled(pointwise(x, up[i]->weight, up[i]->bias));
    for (ResidualBlock& block : blocks_up[i]) x = block(x);
  }
  x = torch::cat({activated(x, norm), input}, 1);
  x = torch::pixel_shuffle(pointwise(x, head->weight, head->bias), 2);
  if (refines) x = x + torch::logit(maps.clamp(kLeastGuidance, 1 - kLeastGuidance));
  return torch::sigmoid(x);
}

}  // namespace ohb::learner
