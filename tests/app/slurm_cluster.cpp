#include "tests/app/slurm_cluster.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>
#include <thread>

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// What a shell's command prints.
std::string printed_by(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen((command + " 2>/dev/null").c_str(), "r"), ::pclose);
  std::string text;
  std::array<char, 256> bytes;
  while (pipe && std::fgets(bytes.data(), static_cast<int>(bytes.size()), pipe.get()) != nullptr) text += bytes.data();
  return text;
}

int free_port() {
  const int end = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  (void)::bind(end, reinterpret_cast<sockaddr*>(&address), size);
  (void)::getsockname(end, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(end);
  return ntohs(address.sin_port);
}

std::string name_of(int node) {
  return "node" + std::to_string(node);
}

/// True if the process runs in this cluster, on this node.
bool runs_on(const fs::path& process, const std::string& configuration, const std::string& node) {
  const std::string environment = read_text(process / "environ");
  const auto has = [&](const std::string& value) { return environment.find(value + '\0') != std::string::npos; };
  return has("SLURM_CONF=" + configuration) && has("SLURMD_NODENAME=" + node);
}

}  // namespace

bool SlurmCluster::is_installed() {
  for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch"}) {
    const std::string name(program);
    if (!fs::exists("/usr/sbin/" + name) && !fs::exists("/usr/bin/" + name)) return false;
  }
  return true;
}

void SlurmCluster::write_configuration() const {
  std::ofstream key(file("munge.key"), std::ios::binary);
  std::random_device random;
  for (int i = 0; i < 128; ++i) key.put(static_cast<char>(random()));
  key.close();
  fs::permissions(file("munge.key"), fs::perms::owner_read);
  fs::create_directories(file("state"));

  const std::string host = printed_by("hostname -s").substr(0, printed_by("hostname -s").find('\n'));
  const std::string user = printed_by("id -un").substr(0, printed_by("id -un").find('\n'));
  const std::string here = folder_.path().string();
  std::ofstream text(file("slurm.conf"));
  text << "ClusterName=scanknit\nSlurmctldHost=" << host << "(127.0.0.1)\nSlurmctldPort=" << free_port()
       << "\nSlurmUser=" << user << "\nSlurmdUser=" << user << "\nAuthType=auth/munge\nAuthInfo=socket=" << here
       << "/munge.socket\nSlurmctldPidFile=" << here << "/slurmctld.pid\nSlurmdPidFile=" << here
       << "/%n.pid\nSlurmdSpoolDir=" << here << "/%n\nStateSaveLocation=" << here << "/state\nSlurmctldLogFile=" << here
       << "/slurmctld.log\nSlurmdLogFile=" << here
       << "/%n.log\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n"
          "SelectTypeParameters=CR_CPU\nMpiDefault=none\nJobAcctGatherType=jobacct_gather/none\nReturnToService=1\n";
  for (int node = 0; node < kNodes; ++node) {
    text << "NodeName=" << name_of(node) << " NodeHostname=" << host << " NodeAddr=127.0.0.1 Port=" << free_port()
         << " CPUs=1\n";
  }
  text << "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n";
}

SlurmCluster::SlurmCluster() {
  write_configuration();
  const std::string here = folder_.path().string();
  ::setenv("SLURM_CONF", file("slurm.conf").c_str(), 1);
  (void)printed_by("/usr/sbin/munged --force --key-file=" + here + "/munge.key --socket=" + here +
                   "/munge.socket --pid-file=" + here + "/munged.pid --log-file=" + here +
                   "/munged.log --seed-file=" + here + "/munge.seed");
  (void)printed_by("/usr/sbin/slurmctld");
  for (int node = 0; node < kNodes; ++node) (void)printed_by("/usr/sbin/slurmd -N " + name_of(node));
}

SlurmCluster::~SlurmCluster() {
  (void)printed_by("scancel --me; scontrol shutdown");
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    if (entry.path().extension() != ".pid") continue;
    const std::string pid = read_text(entry.path());
    if (const int process = std::atoi(pid.c_str()); process > 0) ::kill(process, SIGTERM);
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));  // they write their state into the folder
  ::unsetenv("SLURM_CONF");
}

bool SlurmCluster::is_ready() const {
  for (int tries = 0; tries < 60; ++tries) {
    if (printed_by("sinfo --noheader --format=%D --states=idle").starts_with(std::to_string(kNodes))) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  return false;
}

pid_t SlurmCluster::program_on(int node) const {
  std::error_code code;
  for (const auto& entry : fs::directory_iterator("/proc", code)) {
    const int process = std::atoi(entry.path().filename().c_str());
    const bool is_program = process > 0 && read_text(entry.path() / "comm") == "scanknit\n";
    if (is_program && runs_on(entry.path(), file("slurm.conf"), name_of(node))) return process;
  }
  return 0;
}

void SlurmCluster::lose_node(int node) const {
  const std::string daemon = read_text(file(name_of(node) + ".pid"));
  if (const int process = std::atoi(daemon.c_str()); process > 0) ::kill(process, SIGKILL);
  std::error_code code;
  for (const auto& entry : fs::directory_iterator("/proc", code)) {
    const int process = std::atoi(entry.path().filename().c_str());
    if (process > 0 && runs_on(entry.path(), file("slurm.conf"), name_of(node))) ::kill(process, SIGKILL);
  }
  (void)printed_by("scontrol update nodename=" + name_of(node) + " state=down reason=lost");
  (void)printed_by(
      "for batch in $(squeue --me --array --noheader --states=pending --format=%i); do "
      "scontrol update jobid=$batch starttime=now; done");
}

void SlurmCluster::return_node(int node) const {
  (void)printed_by("/usr/sbin/slurmd -N " + name_of(node));
  (void)printed_by("scontrol update nodename=" + name_of(node) + " state=resume");
}

int SlurmCluster::queued() const {
  const std::string lines = printed_by("squeue --me --array --noheader --format=%i");
  return static_cast<int>(std::count(lines.begin(), lines.end(), '\n'));
}

}  // namespace scanknit
