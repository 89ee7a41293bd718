// The recorder: what was sent is read back bit by bit, and no end of the process or the disk takes more than a second.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <random>
#include <thread>

#include "acquire/mcap/mcap_reader.h"
#include "acquire/raw/raw_decode.h"
#include "acquire/record/picture_message.h"
#include "acquire/record/recorder.h"
#include "acquire/record/repair_recording.h"
#include "raw_frames.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

// So that no load of the machine makes the queue full where the test is about something else.
constexpr RecorderConfig kRoomy{.queue_frames = 100'000};

void record_frames(const fs::path& path, std::uint32_t count) {
  auto recorder = Recorder::create(path, raw_calibration(), kRoomy);
  ASSERT_TRUE(recorder) << recorder.error().text();
  for (std::uint32_t i = 0; i < count; ++i) {
    (*recorder)->record(depth_frame(i));
    (*recorder)->record(colour_frame(i));
    std::this_thread::sleep_for(std::chrono::microseconds(200));  // the queue never fills
  }
  const auto summary = (*recorder)->finish();
  ASSERT_TRUE(summary) << summary.error().text();
  EXPECT_EQ(summary->frames, 2 * count);
  EXPECT_EQ(summary->lost, 0u);
  EXPECT_EQ(summary->bytes, fs::file_size(path));
}

Result<McapReader> read_back(const fs::path& path) {
  return McapReader::open(*open_random_access(path), {});
}

// Number of depth pictures that can be read, all of which must be the ones that were sent.
std::uint32_t whole_frames(const fs::path& path) {
  auto reader = read_back(path);
  if (!reader) return 0;
  std::uint32_t count = 0;
  for (const McapMessagePlace& place : reader->messages()) {
    if (place.channel != reader->find_channel(kDepthTopic)->id) continue;
    const auto data = reader->read(place);
    if (!data) continue;
    const auto frame = unpack_picture(*data, {});
    EXPECT_TRUE(frame);
    EXPECT_EQ(frame->sequence, count);
    EXPECT_EQ(*frame->bytes, *depth_frame(count).bytes);
    ++count;
  }
  return count;
}

class Recording : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  fs::path path_ = folder_ / "scan.mcap";
};

TEST_F(Recording, KeepsEveryByteAndBothClocks) {
  record_frames(path_, 20);
  auto reader = read_back(path_);
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->fault());
  std::uint32_t depth = 0, colour = 0;
  for (const McapMessagePlace& place : reader->messages()) {
    const bool is_depth = place.channel == reader->find_channel(kDepthTopic)->id;
    if (!is_depth && place.channel != reader->find_channel(kColourTopic)->id) continue;
    const RawFrame sent = is_depth ? depth_frame(depth++) : colour_frame(colour++);
    const auto kept = unpack_picture(*reader->read(place), {});
    ASSERT_TRUE(kept);
    EXPECT_EQ(*kept->bytes, *sent.bytes);
    EXPECT_EQ(kept->profile, sent.profile);
    EXPECT_EQ(kept->sequence, sent.sequence);
    EXPECT_EQ(static_cast<std::int64_t>(place.log_ns), sent.host_ns);
    EXPECT_EQ(static_cast<std::int64_t>(place.publish_ns), sent.device_ns);
  }
  EXPECT_EQ(depth, 20u);
  EXPECT_EQ(colour, 20u);
}

TEST_F(Recording, RepeatsTheCalibrationInTheSecondChunkAndEveryTenSeconds) {
  auto recorder = Recorder::create(path_, raw_calibration());
  for (std::uint32_t i = 0; i < 25; ++i) {
    RawFrame frame = depth_frame(i);
    frame.host_ns = i * 1'000'000'000LL;
    (*recorder)->record(std::move(frame));
  }
  ASSERT_TRUE((*recorder)->finish());
  auto reader = read_back(path_);
  const auto calibrations = [&](const McapMessagePlace& place) {
    return place.channel == reader->find_channel(kCalibrationTopic)->id;
  };
  EXPECT_EQ(std::count_if(reader->messages().begin(), reader->messages().end(), calibrations), 4);  // 0, 1, 11, 21 s
  EXPECT_EQ(reader->messages().front().channel, reader->find_channel(kCalibrationTopic)->id);
}

TEST_F(Recording, KeepsTheCalibrationToTheLastBit) {
  RawCalibration sent = raw_calibration();
  EXPECT_EQ(calibration_text(sent).find("baseline"), std::string::npos) << "of a camera without pairs";
  sent.baseline_m = 0.1 / 3;
  const std::string text = calibration_text(sent);
  const auto kept = parse_calibration(std::as_bytes(std::span(text)));
  ASSERT_TRUE(kept) << kept.error().text();
  EXPECT_EQ(kept->depth.intrinsics, sent.depth.intrinsics);
  EXPECT_EQ(kept->colour.intrinsics, sent.colour.intrinsics);
  EXPECT_EQ(kept->T_colour_depth.matrix(), sent.T_colour_depth.matrix());
  EXPECT_EQ(kept->depth_unit_m, sent.depth_unit_m);
  EXPECT_EQ(kept->baseline_m, sent.baseline_m);
  EXPECT_EQ(kept->serial, sent.serial);
}

TEST_F(Recording, WritesTheLossesOfTheScanner) {
  auto recorder = Recorder::create(path_, raw_calibration());
  (*recorder)->note_losses({.device = 1, .transport = 2, .overflow = 3, .queue = 4, .writer = 0});
  (*recorder)->record(depth_frame(0));
  ASSERT_TRUE((*recorder)->finish());
  auto reader = read_back(path_);
  for (const McapMessagePlace& place : reader->messages()) {
    if (place.channel != reader->find_channel(kLossesTopic)->id) continue;
    EXPECT_EQ(parse_losses(*reader->read(place)).value(), (LossCounters{1, 2, 3, 4, 0}));
    return;
  }
  FAIL() << "no message of losses";
}

TEST_F(Recording, IsNotMadeTwice) {
  record_frames(path_, 1);
  const auto before = bytes_of(path_);
  EXPECT_FALSE(Recorder::create(path_, raw_calibration()));
  EXPECT_EQ(bytes_of(path_), before);
}

TEST_F(Recording, WithoutAPictureLeavesNoFile) {
  auto recorder = Recorder::create(path_, raw_calibration());
  ASSERT_TRUE(recorder);
  EXPECT_TRUE((*recorder)->finish());
  EXPECT_FALSE(fs::exists(path_));
}

TEST_F(Recording, IsNotMendedInItsPlaceWhileItIsMade) {
  auto recorder = Recorder::create(path_, raw_calibration(), kRoomy);
  ASSERT_TRUE(recorder);
  (*recorder)->record(depth_frame(0));
  const auto refused = repair_recording(path_, path_, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("still being recorded"), std::string::npos) << refused.error().text();
  (*recorder)->record(depth_frame(1));
  ASSERT_TRUE((*recorder)->finish());
  EXPECT_EQ(whole_frames(path_), 2u);
  recorder->reset();
  EXPECT_TRUE(repair_recording(path_, path_, {}));
}

TEST_F(Recording, ThatIsTakenAwayOrReplacedIsNoSuccess) {
  for (const bool is_replaced : {false, true}) {
    auto recorder = Recorder::create(path_, raw_calibration(), kRoomy);
    ASSERT_TRUE(recorder);
    (*recorder)->record(depth_frame(0));
    fs::remove(path_);
    if (is_replaced) write_text(path_, "another's");
    const auto finished = (*recorder)->finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().code, ErrorCode::kOutput);
    EXPECT_EQ(fs::exists(path_), is_replaced);
  }
}

TEST_F(Recording, IsReadWhereItsFirstChunkIsDamaged) {
  RawCalibration calibration = raw_calibration();
  auto recorder = Recorder::create(path_, calibration, kRoomy);
  for (std::uint32_t i = 0; i < 60; ++i) (*recorder)->record(depth_frame(i));
  ASSERT_TRUE((*recorder)->finish());
  auto bytes = bytes_of(path_);
  bytes[3000] ^=
      std::byte{1};  // behind the head of the file: the counts below tell that it costs a chunk, and one only
  write_bytes(path_, bytes);
  const Played played = play(path_);
  ASSERT_GT(played.frames.size(), 30u);
  EXPECT_LT(played.frames.size(), 60u);
  EXPECT_EQ(played.frames.front().intrinsics, calibration.depth.intrinsics);
}

TEST_F(Recording, CountsWhatTheQueueCannotHold) {
  auto recorder = Recorder::create(path_, raw_calibration(640, 480), {.queue_frames = 1});
  const RawFrame frame = depth_frame(0, 640, 480);
  for (int i = 0; i < 100; ++i) (*recorder)->record(frame);
  const std::uint64_t lost = (*recorder)->lost();
  EXPECT_GT(lost, 0u);
  const auto summary = (*recorder)->finish();
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->frames + summary->lost, 100u);
}

// A camera of a thousand small frames a second, in a process that is killed after `lifetime`. Before each frame its
// number goes through the pipe: the reader's end knows what had been sent and when.
[[noreturn]] void record_until_killed(const fs::path& path, int pipe) {
  auto recorder = Recorder::create(path, raw_calibration(), kRoomy);
  if (!recorder) ::_exit(1);
  for (std::uint32_t i = 0;; ++i) {
    (*recorder)->record(depth_frame(i));
    if (::write(pipe, &i, sizeof i) != sizeof i) ::_exit(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST_F(Recording, KilledAtAnyMomentLosesAtMostItsLastSecond) {
  using Clock = std::chrono::steady_clock;
  constexpr int kKills = 12;
  constexpr std::uint32_t kSeed = 5;
  std::minstd_rand random(kSeed);
  for (int kill_number = 0; kill_number < kKills; ++kill_number) {
    const fs::path path = folder_ / ("killed" + std::to_string(kill_number) + ".mcap");
    int ends[2] = {};
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) record_until_killed(path, ends[1]);
    ::close(ends[1]);
    const auto lifetime = std::chrono::milliseconds(20 + static_cast<int>(random() % 1600));
    const auto begin = Clock::now();
    std::uint32_t sent = 0;          // frames whose sending began
    std::uint32_t sent_in_time = 0;  // of those, more than a second before the end
    std::uint32_t number = 0;
    while (Clock::now() - begin < lifetime && ::read(ends[0], &number, sizeof number) == sizeof number) {
      sent = number + 1;
      if (Clock::now() - begin < lifetime - std::chrono::seconds(1))
        sent_in_time = number;  // the last may be on its way
    }
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    while (::read(ends[0], &number, sizeof number) == sizeof number) sent = number + 1;
    ::close(ends[0]);
    const std::uint32_t kept = fs::exists(path) ? whole_frames(path) : 0;
    EXPECT_GE(kept, sent_in_time) << "killed after " << lifetime.count() << " ms, seed " << kSeed;
    EXPECT_LE(kept, sent + 1);
  }
}

// In a process of its own, since the limit cannot be taken back.
TEST_F(Recording, OnADiskThatIsFullFromTheStartLeavesNoFile) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{0, 0};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
    const auto recorder = Recorder::create(path_, raw_calibration(), kRoomy);
    ::_exit(recorder || recorder.error().code != ErrorCode::kOutput ? 3 : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_FALSE(fs::exists(path_));
}

// In a process of its own, since the limit cannot be taken back: a file may have 300 kB.
TEST_F(Recording, OnAFullDiskKeepsEveryWholeChunkAndSaysSo) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{3'000'000, 3'000'000};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
    auto recorder = Recorder::create(path_, raw_calibration(), kRoomy);
    if (!recorder) ::_exit(3);
    std::uint32_t sent = 0;
    for (; sent < 20'000 && !(*recorder)->failure(); ++sent) {
      (*recorder)->record(depth_frame(sent));
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    const auto failure = (*recorder)->failure();
    if (!failure || failure->code != ErrorCode::kOutput || failure->message.find("stopped") == std::string::npos) {
      ::_exit(4);
    }
    (*recorder)->record(depth_frame(sent));  // the scan goes on
    ::_exit((*recorder)->finish() ? 5 : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_LE(fs::file_size(path_), 3'000'000u);
  EXPECT_GT(fs::file_size(path_), 1'500'000u);
  EXPECT_GT(whole_frames(path_), 100u);
}

}  // namespace
}  // namespace scanknit::test
