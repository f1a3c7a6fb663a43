#include "rank_session.h"

#include <mpi.h>
#include <tbb/info.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <list>
#include <thread>
#include <utility>

using vdbpack::Ranks;

namespace {

/// Bytes that one call of MPI takes: its counts are 32-bit integers.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

class MpiRanks : public Ranks {
public:
    MpiRanks() {
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &count_);
    }

    int rank() const override { return rank_; }
    int count() const override { return count_; }

    void send(int to, Bytes message) override {
        sent_.push_back({MPI_REQUEST_NULL, std::move(message)});
        const Bytes& bytes = sent_.back().bytes;
        MPI_Isend(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, kMessage,
                  MPI_COMM_WORLD, &sent_.back().request);
        forgetSent();
    }
    bool receive(Bytes& message) override {
        forgetSent();
        int arrived = 0;
        MPI_Message handle;
        MPI_Status status;
        MPI_Improbe(MPI_ANY_SOURCE, kMessage, MPI_COMM_WORLD, &arrived, &handle, &status);
        if (!arrived) return false;
        int size = 0;
        MPI_Get_count(&status, MPI_BYTE, &size);
        message.resize(static_cast<std::size_t>(size));
        MPI_Mrecv(message.data(), size, MPI_BYTE, &handle, MPI_STATUS_IGNORE);
        return true;
    }

    void sum(std::vector<std::uint64_t>& numbers) override {
        std::vector<MPI_Request> requests;
        for (std::size_t first = 0; first < numbers.size(); first += kMostBytes / 8) {
            requests.push_back(MPI_REQUEST_NULL);
            MPI_Iallreduce(MPI_IN_PLACE, numbers.data() + first,
                           static_cast<int>(std::min(kMostBytes / 8, numbers.size() - first)),
                           MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD, &requests.back());
        }
        wait(requests);
    }
    std::vector<Bytes> exchange(std::vector<Bytes> toEach) override {
        const auto each = static_cast<std::size_t>(count_);
        std::vector<std::uint64_t> sizes, theirs(each);
        for (const Bytes& bytes : toEach) sizes.push_back(bytes.size());
        std::vector<MPI_Request> requests{MPI_REQUEST_NULL};
        MPI_Ialltoall(sizes.data(), 1, MPI_UINT64_T, theirs.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD,
                      &requests.front());
        wait(requests);
        std::vector<Bytes> fromEach(each);
        requests.clear();
        const auto inPieces = [&](Bytes& bytes, const auto& call) {
            for (std::size_t first = 0; first < bytes.size(); first += kMostBytes) {
                requests.push_back(MPI_REQUEST_NULL);
                call(bytes.data() + first,
                     static_cast<int>(std::min(kMostBytes, bytes.size() - first)),
                     &requests.back());
            }
        };
        for (std::size_t r = 0; r < each; ++r) {
            if (static_cast<int>(r) == rank_) continue;
            fromEach[r].resize(theirs[r]);
            inPieces(fromEach[r], [&](std::byte* to, int size, MPI_Request* request) {
                MPI_Irecv(to, size, MPI_BYTE, static_cast<int>(r), kExchange, MPI_COMM_WORLD,
                          request);
            });
        }
        for (std::size_t r = 0; r < each; ++r) {
            if (static_cast<int>(r) == rank_) continue;
            inPieces(toEach[r], [&](std::byte* from, int size, MPI_Request* request) {
                MPI_Isend(from, size, MPI_BYTE, static_cast<int>(r), kExchange, MPI_COMM_WORLD,
                          request);
            });
        }
        wait(requests);
        const auto self = static_cast<std::size_t>(rank_);
        fromEach[self] = std::move(toEach[self]);
        return fromEach;
    }

private:
    enum Tag : int { kMessage = 1, kExchange = 2 };
    struct Sent {
        MPI_Request request;
        Bytes bytes;
    };

    /// Looks often at first, then leaves the core to others: MPI_Waitall would keep it busy.
    static void wait(std::vector<MPI_Request>& requests) {
        constexpr int kOften = 100;
        for (int k = 0;; ++k) {
            int done = 0;
            MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done,
                        MPI_STATUSES_IGNORE);
            if (done) return;
            if (k > kOften) std::this_thread::sleep_for(std::chrono::microseconds(20));
        }
    }
    void forgetSent() {
        while (!sent_.empty()) {
            int done = 0;
            MPI_Test(&sent_.front().request, &done, MPI_STATUS_IGNORE);
            if (!done) return;
            sent_.pop_front();
        }
    }

    int rank_ = 0, count_ = 1;
    std::list<Sent> sent_;
};

class MpiSession : public RankSession {
public:
    MpiSession() { MPI_Comm_dup(MPI_COMM_WORLD, &ending_); }

    Ranks& ranks() override { return ranks_; }
    int threads() const override {
        MPI_Comm machine;
        MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
        int here = 1;
        MPI_Comm_size(machine, &here);
        MPI_Comm_free(&machine);
        const int cores = static_cast<int>(::sysconf(_SC_NPROCESSORS_ONLN));
        // Those that mpirun binds it to, if it does.
        const int allowed = tbb::info::default_concurrency();
        return std::max(1, std::min(allowed, cores / here));
    }
    int end(bool failed, int exitCode, const std::function<void()>& tell) override {
        const int own = failed;
        int failures = 0;
        MPI_Request request;
        MPI_Iallreduce(&own, &failures, 1, MPI_INT, MPI_SUM, ending_, &request);
        const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(2);
        for (;;) {
            int done = 0;
            MPI_Test(&request, &done, MPI_STATUS_IGNORE);
            if (done) break;
            if (failed && std::chrono::steady_clock::now() > latest) {
                tell();
                MPI_Abort(MPI_COMM_WORLD, exitCode);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        const bool alike = failures == 0 || failures == ranks_.count();
        if (failed && (!alike || ranks_.isFirst())) tell();
        // mpirun ends what is left once a process ends with an exit code other than 0.
        for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, SIG_DFL);
        MPI_Finalize();
        return !alike || ranks_.isFirst() ? exitCode : 0;
    }

private:
    MpiRanks ranks_;
    MPI_Comm ending_;
};

}  // namespace

std::unique_ptr<RankSession> startRanks() {
    // Started alone, a process does without the time that MPI takes.
    const char* const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "PMI_RANK"};
    if (std::none_of(std::begin(names), std::end(names),
                     [](const char* name) { return std::getenv(name) != nullptr; }))
        return nullptr;
    int provided = 0;
    // One thread at a time speaks, not always the same.
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    int count = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    if (count > 1) return std::make_unique<MpiSession>();
    MPI_Finalize();
    return nullptr;
}
