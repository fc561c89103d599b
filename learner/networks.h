// The paper's networks: three priors (geometry; diffuse albedo; roughness, specular and subsurface) of one
// shape, and the finetuning model that refines their maps together; and one network of our own for all maps.
//
// What the paper leaves open is chosen as docs/learner.md says. In short, with widths at multiplier 1:
//   stem 1x1 64 @1; down 128 @1/2, 256 @1/4, 512 @1/8, 512 @1/16; transformer 512 @1/16;
//   up 512 @1/8, 256 @1/4, 128 @1/2, 64 @1; skips and guidance are concatenated at equal scale;
//   head: three residual blocks, a two-layer MLP of 1x1 convolutions, sigmoid.
// Parameter names are the checkpoint's schema: never rename them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "learner/maps.h"
#include "learner/torch.h"

namespace ohb::learner {

/// Height and width of every input must be multiples of this.
constexpr int64_t kResolutionStep = 16;

/// Channels of a layer that has `channels` at multiplier 1: rounded to a multiple of 16, at least 16.
int64_t scaled_width(int64_t channels, double multiplier);

/// 1x1 convolution, up-sampling if asked, 3x3 convolution (of stride 2 if asked), group norm, SiLU.
struct ConvBlockImpl : torch::nn::Module {
  enum class Scale { kSame, kDown, kUp };
  ConvBlockImpl(int64_t in, int64_t out, Scale scale);
  torch::Tensor forward(torch::Tensor x);

  Scale scale;
  torch::nn::Conv2d mix{nullptr}, conv{nullptr};
  torch::nn::GroupNorm norm{nullptr};
};
TORCH_MODULE(ConvBlock);

/// Guidance features at 1/2, 1/4 and 1/8 of the size: nine blocks, three a scale.
struct GuidanceEncoderImpl : torch::nn::Module {
  GuidanceEncoderImpl(int64_t in, double width);
  std::array<torch::Tensor, 3> forward(torch::Tensor x);

  std::vector<ConvBlock> blocks;
  std::array<int64_t, 3> channels;
};
TORCH_MODULE(GuidanceEncoder);

/// Pre-norm cross-attention from the latent to the guidance, self-attention and a feed-forward layer, 8
/// heads, with fixed 2-D sine and cosine positions. Any number of tokens.
struct FusionBlockImpl : torch::nn::Module {
  FusionBlockImpl(int64_t channels, int64_t guidance_channels);
  /// latent (B, channels, h, w); each guidance (B, guidance_channels, 2h, 2w), pooled to h x w here.
  torch::Tensor forward(const torch::Tensor& latent, const std::vector<torch::Tensor>& guidance);

 private:
  torch::Tensor attend(const torch::Tensor& queries, const torch::Tensor& keys, const torch::Tensor& values);

  torch::nn::LayerNorm norm_latent_{nullptr}, norm_guidance_{nullptr}, norm_self_{nullptr},
      norm_mlp_{nullptr};
  torch::nn::Linear query_{nullptr}, key_{nullptr}, value_{nullptr}, cross_out_{nullptr}, self_in_{nullptr},
      self_out_{nullptr}, mlp_in_{nullptr}, mlp_out_{nullptr};
  static constexpr int64_t kHeads = 8;
};
TORCH_MODULE(FusionBlock);

/// Features of the foreground at full, 1/2, 1/4, 1/8 (for skips) and 1/16 of the size.
struct LatentEncoderImpl : torch::nn::Module {
  LatentEncoderImpl(int64_t in, double width);
  std::array<torch::Tensor, 5> forward(const torch::Tensor& x);

  torch::nn::Conv2d stem{nullptr};
  std::array<ConvBlock, 4> down{nullptr, nullptr, nullptr, nullptr};
};
TORCH_MODULE(LatentEncoder);

/// From the fused latent up to maps, as logits.
struct DecoderImpl : torch::nn::Module {
  DecoderImpl(int64_t out, double width);
  torch::Tensor forward(torch::Tensor latent, const std::array<torch::Tensor, 5>& skips,
                        const std::array<torch::Tensor, 3>& guidance);

  std::array<ConvBlock, 4> up{nullptr, nullptr, nullptr, nullptr};
  torch::nn::Conv2d merge{nullptr}, hidden{nullptr}, output{nullptr};
  std::array<torch::nn::Conv2d, 6> refine{nullptr, nullptr, nullptr, nullptr, nullptr, nullptr};
};
TORCH_MODULE(Decoder);

/// A prior. Input (B, 4, H, W): sRGB times mask, and mask, as 2x - 1. Output (B, out, H, W) in (0, 1):
/// geometry 4 (normal as (n + 1) / 2, displacement as 0.5 + d / 2), albedo 3 (linear), rss 3 (roughness,
/// specular S, sss).
struct PriorNetImpl : torch::nn::Module {
  PriorNetImpl(int64_t out, double width);
  torch::Tensor forward(torch::Tensor input);

  LatentEncoder encoder{nullptr};
  GuidanceEncoder guidance{nullptr};
  FusionBlock fusion{nullptr};
  Decoder decoder{nullptr};
};
TORCH_MODULE(PriorNet);

/// The finetuning model. `maps` (B, 10, H, W) in (0, 1) are the guidance: normal 3, displacement 1, diffuse
/// 3, rss 3, as the priors put them out; the output has the same ten channels.
struct FinetuneNetImpl : torch::nn::Module {
  explicit FinetuneNetImpl(double width);
  torch::Tensor forward(torch::Tensor input, const torch::Tensor& maps);

  static constexpr std::array<int64_t, 4> kChannels = {3, 1, 3, rss_channels()};
  static constexpr std::array<const char*, 4> kNames = {"normal", "displacement", "diffuse", "rss"};
  LatentEncoder encoder{nullptr};
  FusionBlock fusion{nullptr};
  std::array<GuidanceEncoder, 4> guidance{nullptr, nullptr, nullptr, nullptr};
  std::array<Decoder, 4> decoders{nullptr, nullptr, nullptr, nullptr};
};
TORCH_MODULE(FinetuneNet);

/// x + conv(norm, SiLU(conv(norm, SiLU(x)))), 3x3 each (He, Zhang, Ren and Sun 2016, pre-activation).
struct ResidualBlockImpl : torch::nn::Module {
  explicit ResidualBlockImpl(int64_t channels);
  torch::Tensor forward(const torch::Tensor& x);

  std::array<torch::nn::GroupNorm, 2> norm{nullptr, nullptr};
  std::array<torch::nn::Conv2d, 2> conv{nullptr, nullptr};
};
TORCH_MODULE(ResidualBlock);

/// All maps by one trunk (not in the paper). Input as a prior's, output as the finetuning model's. Pixels are
/// gathered two by two at once, so that nothing but that runs at full size: 128 channels at 1/2, 256 at 1/4,
/// 512 at 1/8 and 1024 at 1/16 at multiplier 1, residual blocks, skips that are added, and at 1/16 the
/// transformer block, whose guidance is what the trunk saw at 1/8.
///
/// `refines`: it takes maps (B, out, H, W) in (0, 1) too, and their logits are added to its own, which begin
/// at 0, so that an untrained network gives the maps back (values within kLeastGuidance of 0 and 1 held
/// there).
struct JointNetImpl : torch::nn::Module {
  JointNetImpl(int64_t out, double width, bool refines = false);
  torch::Tensor forward(torch::Tensor input, const torch::Tensor& maps = {});

  static constexpr double kLeastGuidance = 1e-3;
  bool refines;
  static constexpr std::array<int64_t, 4> kWidths = {128, 256, 512, 1024};
  static constexpr std::array<int, 4> kBlocksDown = {1, 1, 2, 1}, kBlocksUp = {1, 1, 1, 1};
  torch::nn::Conv2d stem{nullptr}, head{nullptr};
  std::array<std::vector<ResidualBlock>, 4> blocks_down, blocks_up;
  std::array<torch::nn::Conv2d, 3> down{nullptr, nullptr, nullptr}, up{nullptr, nullptr, nullptr};
  FusionBlock fusion{nullptr};
  torch::nn::GroupNorm norm{nullptr};
};
TORCH_MODULE(JointNet);

}  // namespace ohb::learner
