// Ranks that are threads of one process.
#pragma once

#include "vdbpack/core/ranks.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace vdbpack {

/// What the threads share.
struct RankOffice {
    explicit RankOffice(int n)
        : count(n), boxes(static_cast<std::size_t>(n)), parcels(static_cast<std::size_t>(n)) {}

    /// Waits until all are here.
    void meet(std::unique_lock<std::mutex>& lock) {
        const std::uint64_t round = rounds;
        if (++here == count) {
            here = 0;
            ++rounds;
            met.notify_all();
        }
        met.wait(lock, [&] { return rounds != round; });
    }

    const int count;
    std::mutex mutex;
    std::condition_variable met;
    int here = 0;
    std::uint64_t rounds = 0;
    std::vector<std::deque<Ranks::Bytes>> boxes;
    std::vector<std::vector<Ranks::Bytes>> parcels;  // by sender
    std::vector<std::uint64_t> total;
    std::size_t messages = 0, bytes = 0;  // sent one by one
};

class ThreadRank : public Ranks {
public:
    ThreadRank(RankOffice& office, int rank) : office_(office), rank_(rank) {}

    int rank() const override { return rank_; }
    int count() const override { return office_.count; }
    void send(int to, Bytes message) override {
        const std::lock_guard<std::mutex> lock(office_.mutex);
        ++office_.messages;
        office_.bytes += message.size();
        office_.boxes[static_cast<std::size_t>(to)].push_back(std::move(message));
    }
    bool receive(Bytes& message) override {
        const std::lock_guard<std::mutex> lock(office_.mutex);
        auto& box = office_.boxes[static_cast<std::size_t>(rank_)];
        if (box.empty()) return false;
        message = std::move(box.front());
        box.pop_front();
        return true;
    }
    void sum(std::vector<std::uint64_t>& numbers) override {
        std::unique_lock<std::mutex> lock(office_.mutex);
        if (office_.here == 0) office_.total.assign(numbers.size(), 0);
        for (std::size_t i = 0; i < numbers.size(); ++i) office_.total[i] += numbers[i];
        office_.meet(lock);
        numbers = office_.total;
        office_.meet(lock);
    }
    std::vector<Bytes> exchange(std::vector<Bytes> toEach) override {
        std::unique_lock<std::mutex> lock(office_.mutex);
        office_.parcels[static_cast<std::size_t>(rank_)] = std::move(toEach);
        office_.meet(lock);
        std::vector<Bytes> fromEach;
        for (const auto& parcel : office_.parcels)
            fromEach.push_back(parcel[static_cast<std::size_t>(rank_)]);
        office_.meet(lock);
        return fromEach;
    }

private:
    RankOffice& office_;
    int rank_;
};

/// Calls `work(ranks)` on each rank. The exception of one passes through, once all have ended.
template <class Work>
void onRanks(RankOffice& office, const Work& work) {
    std::vector<std::thread> threads;
    std::exception_ptr failure;
    for (int r = 0; r < office.count; ++r)
        threads.emplace_back([&, r] {
            ThreadRank rank(office, r);
            try {
                work(rank);
            } catch (...) {
                const std::lock_guard<std::mutex> lock(office.mutex);
                failure = std::current_exception();
            }
        });
    for (auto& thread : threads) thread.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace vdbpack
