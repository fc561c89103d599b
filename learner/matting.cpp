#include "learner/matting.h"

#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "dataset/model/colour.h"
#include "dataset/model/error.h"

namespace ohb::learner {
namespace fs = std::filesystem;
namespace {

constexpr int kNetwork_px = 256;
constexpr int kGrabCut_px = 384;
constexpr int kCut_px = 640;  // of the person's surroundings: more takes seconds
// Larger photos are worked on at this size: a matte for maps of up to 1024 px needs no more, and ten floats a
// pixel of a photo of 100 million would take gigabytes and minutes.
constexpr int kWorking_px = 2048;
constexpr double kSmallestShare = 0.003;  // of the picture: less is no person
constexpr double kMargin = 0.2;           // around the first pass's box, of its longer side

/// A picture of at most kWorking_px a side, averaged down where it is larger. Not a copy where it is not.
cv::Mat reduced(const cv::Mat& picture) {
  const double scale = kWorking_px / static_cast<double>(std::max(picture.rows, picture.cols));
  if (scale >= 1) return picture;
  cv::Mat small;
  cv::resize(picture, small, cv::Size(), scale, scale, cv::INTER_AREA);
  return small;
}

/// Back to the photo's size, if it was reduced.
cv::Mat enlarged(const cv::Mat& picture, const cv::Size& size) {
  if (picture.size() == size) return picture;
  cv::Mat large;
  cv::resize(picture, large, size, 0, 0, cv::INTER_LINEAR);
  return large;
}

/// The pixels themselves, not a copy.
cv::Mat pixels_of(const Image& image) {
  return cv::Mat(image.height_px, image.width_px, CV_32FC(image.channels),
                 const_cast<float*>(image.values.data()));
}

/// sRGB-encoded, RGB, three floats a pixel.
cv::Mat encoded(const cv::Mat& linear) {
  cv::Mat picture(linear.size(), CV_32FC3);
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at<cv::Vec3f>(y, x)[c] =
            linear_to_srgb(std::clamp(linear.at<cv::Vec3f>(y, x)[c], 0.0f, 1.0f));
  return picture;
}

/// OpenCV's words in one line. A damaged file also makes its reader run out of memory or of its own ranges.
std::string words_of(const std::exception& error, const std::string& otherwise) {
  const auto* of_opencv = dynamic_cast<const cv::Exception*>(&error);
  std::string words = of_opencv && !of_opencv->err.empty() ? of_opencv->err : otherwise;
  std::replace(words.begin(), words.end(), '\n', ' ');
  return words.substr(words.find_first_not_of("> ") == std::string::npos ? 0 : words.find_first_not_of("> "));
}

[[noreturn]] void throw_no_network(const fs::path& file, const std::string& cause) {
  throw InputError(file.string(), "", "is no matting network that can be used: " + cause,
                   "give an ONNX file that takes 1 x 3 x 256 x 256 and gives one plane of that size");
}

/// OpenCV's reader of ONNX ends the process on some damaged files (4.6: segmentation fault): a child meets
/// them first.
void try_in_a_child(const fs::path& file) {
  constexpr unsigned kPatience_s = 120;
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGSEGV, SIG_DFL);
    ::signal(SIGABRT, SIG_DFL);
    ::alarm(kPatience_s);
    cv::setNumThreads(0);
    try {
      cv::dnn::Net net = cv::dnn::readNetFromONNX(file.string());
      net.setInput(cv::dnn::blobFromImage(cv::Mat::zeros(kNetwork_px, kNetwork_px, CV_32FC3)));
      net.forward();
    } catch (...) {  // is said in words when we read it ourselves
    }
    ::_exit(0);
  }
  int status = 0;
  while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (child > 0 && status != 0)  // a signal, or an exit that is not ours
    throw_no_network(file, WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM
                               ? "it takes more than two minutes"
                               : "it is damaged: OpenCV does not survive it");
}

/// The probability of "person" from an ONNX network.
class Network {
 public:
  explicit Network(const fs::path& file) : file_(file) {
    if (!fs::is_regular_file(file)) throw_no_network(file, "there is no such file");
    // Its words come with the exception; on stderr they would come twice.
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    try_in_a_child(file);
    try {
      net_ = cv::dnn::readNetFromONNX(file.string());
    } catch (const std::exception& error) {
      throw_no_network(file, words_of(error, "it cannot be read"));
    }
    if (net_.empty()) throw_no_network(file, "it is empty");
  }

  /// Of the size of `picture`, which is stretched to the network's.
  cv::Mat probability(const cv::Mat& picture) {
    cv::Mat out;
    try {
      net_.setInput(cv::dnn::blobFromImage(picture, 1, cv::Size(kNetwork_px, kNetwork_px)));
      out = net_.forward();
    } catch (const std::exception& error) {
      throw_no_network(file_, words_of(error, "it fails on a picture"));
    }
    if (out.dims != 4 || out.size[0] != 1 || out.size[1] != 1 || out.size[2] != kNetwork_px ||
        out.size[3] != kNetwork_px || out.type() != CV_32F)
      throw_no_network(file_, "its output is not one plane of 256 x 256");
    cv::Mat plane(kNetwork_px, kNetwork_px, CV_32F, out.ptr<float>()), resized;
    if (!cv::checkRange(plane)) throw_no_network(file_, "it puts out NaN");
    cv::resize(plane, resized, picture.size(), 0, 0, cv::INTER_LINEAR);
    return cv::max(cv::min(resized, 1.0), 0.0);
  }

 private:
  fs::path file_;
  cv::dnn::Net net_;
};

/// What differs from the borders, at a moderate size.
cv::Mat by_grab_cut(const cv::Mat& picture) {
  const double scale = std::min(1.0, kGrabCut_px / static_cast<double>(std::max(picture.rows, picture.cols)));
  cv::Mat small, bytes, labels, background, foreground;
  cv::resize(picture, small, cv::Size(), scale, scale, cv::INTER_AREA);
  small.convertTo(bytes, CV_8UC3, 255);
  cv::setRNGSeed(1);
  const int x = std::max(1, bytes.cols / 20), y = std::max(1, bytes.rows / 50);
  cv::grabCut(bytes, labels, cv::Rect(x, y, bytes.cols - 2 * x, bytes.rows - 2 * y), background, foreground,
              6, cv::GC_INIT_WITH_RECT);
  cv::Mat mask = (labels & 1), floats, resized;
  mask.convertTo(floats, CV_32F);
  cv::resize(floats, resized, picture.size(), 0, 0, cv::INTER_LINEAR);
  return resized;
}

/// Regions with probability above a half, by area, largest first; `labels` names them by their rank from 1.
std::vector<cv::Rect> regions_of(const cv::Mat& probability, cv::Mat& labels) {
  cv::Mat found, statistics, centres;
  const int count =
      cv::connectedComponentsWithStats(probability > 0.5, found, statistics, centres, 8, CV_32S);
  std::vector<int> order;
  const double least = kSmallestShare * static_cast<double>(probability.total());
  for (int i = 1; i < count; ++i)
    if (statistics.at<int>(i, cv::CC_STAT_AREA) >= least) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const int area_a = statistics.at<int>(a, cv::CC_STAT_AREA),
              area_b = statistics.at<int>(b, cv::CC_STAT_AREA);
    return area_a != area_b ? area_a > area_b : a < b;
  });
  labels = cv::Mat::zeros(probability.size(), CV_32S);
  std::vector<cv::Rect> boxes;
  for (const int i : order) {
    labels.setTo(static_cast<int>(boxes.size()) + 1, found == i);
    boxes.emplace_back(statistics.at<int>(i, cv::CC_STAT_LEFT), statistics.at<int>(i, cv::CC_STAT_TOP),
                       statistics.at<int>(i, cv::CC_STAT_WIDTH), statistics.at<int>(i, cv::CC_STAT_HEIGHT));
  }
  return boxes;
}

/// The box with a margin, within the picture.
cv::Rect surroundings(const cv::Rect& box, const cv::Size& size) {
  const int margin = static_cast<int>(std::lround(kMargin * std::max(box.width, box.height)));
  return cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
         cv::Rect(cv::Point(0, 0), size);
}

/// The guided filter of a mask by a picture in grey: within each window the mask is a line in the grey value.
cv::Mat guided(const cv::Mat& grey, const cv::Mat& mask, int radius_px, double epsilon) {
  const cv::Size window(2 * radius_px + 1, 2 * radius_px + 1);
  const auto mean = [&](const cv::Mat& x) {
    cv::Mat out;
    cv::boxFilter(x, out, CV_32F, window);
    return out;
  };
  const cv::Mat grey_mean = mean(grey), mask_mean = mean(mask);
  const cv::Mat covariance = mean(grey.mul(mask)) - grey_mean.mul(mask_mean);
  const cv::Mat variance = mean(grey.mul(grey)) - grey_mean.mul(grey_mean);
  cv::Mat slope;
  cv::divide(covariance, variance + epsilon, slope);
  const cv::Mat level = mask_mean - slope.mul(grey_mean);
  return mean(slope).mul(grey) + mean(level);
}

cv::Mat disc_of(int radius_px) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * radius_px + 1, 2 * radius_px + 1));
}

/// The mask with its edge where colours say, within `radius_px` of where it was: a graph cut (GrabCut) that
/// may change nothing further off. The network's edge is as coarse as its 256 pixels, and fills gaps between
/// legs.
cv::Mat cut_by_colours(const cv::Mat& whole, const cv::Mat& whole_coarse, int whole_radius_px) {
  const double scale = std::min(1.0, kCut_px / static_cast<double>(std::max(whole.rows, whole.cols)));
  const int radius_px = std::max(2, static_cast<int>(std::lround(scale * whole_radius_px)));
  cv::Mat picture, coarse;
  cv::resize(whole, picture, cv::Size(), scale, scale, cv::INTER_AREA);
  cv::resize(whole_coarse, coarse, picture.size(), 0, 0, cv::INTER_AREA);
  cv::Mat core, around, bytes, labels(coarse.size(), CV_8U, cv::Scalar(cv::GC_BGD));
  const cv::Mat inside = coarse > 0.5;
  cv::erode(inside, core, disc_of(radius_px));
  cv::dilate(inside, around, disc_of(radius_px));
  labels.setTo(cv::GC_PR_BGD, around);
  labels.setTo(cv::GC_PR_FGD, inside);
  labels.setTo(cv::GC_FGD, core);
  if (cv::countNonZero(core) == 0 || cv::countNonZero(around == 0) == 0) return whole_coarse;
  picture.convertTo(bytes, CV_8UC3, 255);
  cv::Mat background, foreground, mask;
  cv::setRNGSeed(1);
  cv::grabCut(bytes, labels, cv::Rect(), background, foreground, 3, cv::GC_INIT_WITH_MASK);
  const cv::Mat found = labels & 1;
  found.convertTo(mask, CV_32F);
  return enlarged(mask, whole.size());
}

/// A coarse mask, all of it in `near`, with its edge on the picture's; far from the edge it is 0 or 1.
cv::Mat refined(const cv::Mat& picture, const cv::Mat& coarse, const cv::Rect& near, int side_px) {
  const int radius = std::max(2, side_px / 60);
  cv::Mat mask = cv::Mat::zeros(coarse.size(), CV_32F), grey;
  cut_by_colours(picture(near), coarse(near), 2 * radius).copyTo(mask(near));
  cv::cvtColor(picture, grey, cv::COLOR_RGB2GRAY);
  // A quarter of it from the network: its doubt makes the edge soft.
  const int fine = std::max(1, radius / 3);
  cv::Mat soft = guided(grey, 0.75 * mask + 0.25 * coarse, fine, 1e-4);
  soft = cv::max(cv::min((soft - 0.25) / 0.5, 1.0), 0.0);
  cv::Mat core, around;
  cv::erode(coarse > 0.5, core, disc_of(2 * radius));
  cv::dilate(coarse > 0.5, around, disc_of(2 * radius));
  soft.setTo(1, core);
  soft.setTo(0, around == 0);
  return soft;
}

Image image_of(const cv::Mat& plane) {
  Image image(plane.cols, plane.rows, 1);
  for (int y = 0; y < plane.rows; ++y)
    std::copy(plane.ptr<float>(y), plane.ptr<float>(y) + plane.cols, image.pixel(0, y));
  return image;
}

}  // namespace

Matte find_person(const Photo& photo, const fs::path& photo_file, const MattingOptions& options) {
  const cv::Mat picture = encoded(reduced(pixels_of(photo.linear)));
  std::optional<Network> network;
  if (options.network) network.emplace(*options.network);
  cv::Mat probability = network ? network->probability(picture) : by_grab_cut(picture);
  if (!network)
    spdlog::warn(
        "{}: has no alpha, and there is no --mask and no --matting: what differs from the picture's borders "
        "is "
        "taken for the person; look at mask.png",
        photo_file.string());
  cv::Mat labels;
  const std::vector<cv::Rect> boxes = regions_of(probability, labels);
  const std::string cutout = "cut the person out and give --mask";
  if (boxes.empty()) throw InputError(photo_file.string(), "", "nobody was found in it", cutout);
  if (options.person > static_cast<int>(boxes.size()))
    throw InputError(photo_file.string(), "--person " + std::to_string(options.person),
                     "only " + std::to_string(boxes.size()) + " found", "name another, or " + cutout);
  const cv::Rect box = boxes[static_cast<size_t>(options.person - 1)];
  // Other persons stay out, whatever the second look says about them.
  cv::Mat others = (labels != options.person) & (labels != 0);
  const cv::Rect near = surroundings(box, picture.size());
  cv::Mat coarse = cv::Mat::zeros(picture.size(), CV_32F);
  if (network) {
    network->probability(picture(near)).copyTo(coarse(near));
  } else {
    probability(near).copyTo(coarse(near));
  }
  coarse.setTo(0, others);
  cv::Mat near_labels;
  if (!regions_of(coarse, near_labels).empty()) coarse.setTo(0, (near_labels != 1) & (coarse > 0.5));
  Matte matte;
  const cv::Mat soft = refined(picture, coarse, near, std::max(box.width, box.height));
  matte.mask = image_of(enlarged(soft, cv::Size(photo.linear.width_px, photo.linear.height_px)));
  matte.people = static_cast<int>(boxes.size());
  return matte;
}

void keep_foreground_colours(Photo& photo, const Image& mask) {
  const cv::Mat whole_alpha = pixels_of(mask), whole = pixels_of(photo.linear);
  const cv::Mat alpha = reduced(whole_alpha), colours = reduced(whole);
  cv::Mat alpha3, foreground = colours.clone(), background = colours.clone();
  cv::merge(std::vector<cv::Mat>{alpha, alpha, alpha}, alpha3);
  const cv::Mat rest3 = cv::Scalar::all(1) - alpha3;
  const int side = std::max(alpha.cols, alpha.rows);
  for (const int radius : {std::max(4, side / 20), std::max(2, side / 150)}) {
    const cv::Size window(2 * radius + 1, 2 * radius + 1);
    const auto weighted = [&](const cv::Mat& x, const cv::Mat& weight) {
      cv::Mat sum, total, out;
      cv::blur(x.mul(weight), sum, window);
      cv::blur(weight, total, window);
      cv::divide(sum, total + cv::Scalar::all(1e-5), out);
      return out;
    };
    foreground = weighted(foreground, alpha3);
    background = weighted(background, rest3);
    foreground += alpha3.mul(colours - alpha3.mul(foreground) - rest3.mul(background));
    foreground = cv::max(foreground, 0.0);
  }
  enlarged(foreground, whole.size()).copyTo(whole, (whole_alpha > 0) & (whole_alpha < 0.999));
}

}  // namespace ohb::learner
