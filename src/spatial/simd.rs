//! Eight `f32` at once: with AVX2 where the processor has it, found out at run time, and as plain loops elsewhere.
//!
//! Both give the same answers to the last bit: no operation is fused, and minima and maxima of a NaN are defined. The
//! only unsafe code of this crate is here: vector instructions, which are called after the processor was asked,
//! prefetching, which reads nothing, and advice to the system about memory, which changes nothing that is in it.
#![expect(
    unsafe_code,
    reason = "vector instructions that are called after the processor was asked for them"
)]

use std::array;

/// The number of lanes.
pub(crate) const LANES: usize = 8;

/// Operations on eight lanes. Bit masks have lane 0 in the lowest bit.
///
/// To be used inside of a [`Task`]: anything else is slow. Functions that take a `Simd` must be `#[inline(always)]`, so
/// that they are compiled for the processor that the task runs on.
pub(crate) trait Simd: Copy {
    /// Eight `f32`.
    type F32s: Copy;

    fn load(self, values: &[f32; LANES]) -> Self::F32s;
    fn splat(self, value: f32) -> Self::F32s;
    fn store(self, values: Self::F32s) -> [f32; LANES];
    fn add(self, a: Self::F32s, b: Self::F32s) -> Self::F32s;
    fn sub(self, a: Self::F32s, b: Self::F32s) -> Self::F32s;
    fn mul(self, a: Self::F32s, b: Self::F32s) -> Self::F32s;
    /// `if a < b { a } else { b }`: the second if either is NaN.
    fn min(self, a: Self::F32s, b: Self::F32s) -> Self::F32s;
    /// `if a > b { a } else { b }`: the second if either is NaN.
    fn max(self, a: Self::F32s, b: Self::F32s) -> Self::F32s;
    /// The lanes in which `a <= b`.
    fn le(self, a: Self::F32s, b: Self::F32s) -> u32;
    /// The lanes in which `a < b`.
    fn lt(self, a: Self::F32s, b: Self::F32s) -> u32;
    /// `values` in the lanes of the mask, and `otherwise` in the others.
    fn select(self, lanes: u32, values: Self::F32s, otherwise: Self::F32s) -> Self::F32s;
    /// The least of the lanes, none of which may be NaN.
    fn min_lane(self, values: Self::F32s) -> f32;
    /// The values with those of their `bits` that are set in `mask` taken from `tags`, which has no others.
    fn tag(self, values: Self::F32s, mask: u32, tags: &[u32; LANES]) -> Self::F32s;
    /// The first values of all rows, the second ones, and so on.
    fn transpose(self, rows: [&[f32; 4]; LANES]) -> [Self::F32s; 4];
    /// The lanes that have a bit in common with `bits`.
    fn with_any_bit(self, values: &[u32; LANES], bits: u32) -> u32;
}

/// Something to be done with [`Simd`] operations. `run` must be `#[inline(always)]`.
pub(crate) trait Task {
    type Output;

    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs a task with the widest instructions that this processor has.
#[inline]
pub(crate) fn dispatch<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi2") {
        // SAFETY: the processor has been asked for every feature that the function enables; AVX2 implies the older ones.
        return unsafe { avx2::run(task) };
    }
    task.run(Portable)
}

/// Asks for a value to be brought close, for it will be read soon. Reads nothing.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of::<T>()).step_by(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch reads nothing, whatever the address; this one is inside of `value`.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast::<i8>().add(line)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// An empty vector with room for so many values, in huge pages if it is large and the system has them to give: what is
/// read here and there then misses the table of pages less often. Linux gives them to those that ask.
pub(crate) fn with_huge_pages<T>(capacity: usize) -> Vec<T> {
    let values: Vec<T> = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        const HUGE_PAGE: usize = 2 << 20;
        const MADV_HUGEPAGE: std::ffi::c_int = 14;
        unsafe extern "C" {
            fn madvise(address: *mut std::ffi::c_void, length: usize, advice: std::ffi::c_int) -> std::ffi::c_int;
        }
        let start = values.as_ptr().addr().next_multiple_of(PAGE);
        let end = values.as_ptr().addr() + capacity * size_of::<T>();
        if end.saturating_sub(start) >= 2 * HUGE_PAGE {
            // SAFETY: advice of how to keep memory, which this vector owns, changes nothing that is in it.
            unsafe { madvise(std::ptr::with_exposed_provenance_mut(start), end - start, MADV_HUGEPAGE) };
        }
    }
    values
}

/// Plain loops, which the compiler turns into what vector instructions the target always has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Portable {
    #[inline(always)]
    fn zip(a: [f32; LANES], b: [f32; LANES], f: impl Fn(f32, f32) -> f32) -> [f32; LANES] {
        array::from_fn(|lane| f(a[lane], b[lane]))
    }

    #[inline(always)]
    fn mask(is_set: impl Fn(usize) -> bool) -> u32 {
        (0..LANES).fold(0, |mask, lane| mask | u32::from(is_set(lane)) << lane)
    }
}

impl Simd for Portable {
    type F32s = [f32; LANES];

    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> Self::F32s {
        *values
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::F32s {
        [value; LANES]
    }

    #[inline(always)]
    fn store(self, values: Self::F32s) -> [f32; LANES] {
        values
    }

    #[inline(always)]
    fn add(self, a: Self::F32s, b: Self::F32s) -> Self::F32s {
        Self::zip(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, a: Self::F32s, b: Self::F32s) -> Self::F32s {
        Self::zip(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, a: Self::F32s, b: Self::F32s) -> Self::F32s {
        Self::zip(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn min(self, a: Self::F32s, b: Self::F32s) -> Self::F32s {
        Self::zip(a, b, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, a: Self::F32s, b: Self::F32s) -> Self::F32s {
        Self::zip(a, b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn le(self, a: Self::F32s, b: Self::F32s) -> u32 {
        Self::mask(|lane| a[lane] <= b[lane])
    }

    #[inline(always)]
    fn lt(self, a: Self::F32s, b: Self::F32s) -> u32 {
        Self::mask(|lane| a[lane] < b[lane])
    }

    #[inline(always)]
    fn select(self, lanes: u32, values: Self::F32s, otherwise: Self::F32s) -> Self::F32s {
        array::from_fn(|lane| {
            if lanes & 1 << lane != 0 {
                values[lane]
            } else {
                otherwise[lane]
            }
        })
    }

    #[inline(always)]
    fn min_lane(self, values: Self::F32s) -> f32 {
        values.into_iter().fold(f32::INFINITY, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn tag(self, values: Self::F32s, mask: u32, tags: &[u32; LANES]) -> Self::F32s {
        array::from_fn(|lane| f32::from_bits(values[lane].to_bits() & !mask | tags[lane]))
    }

    #[inline(always)]
    fn transpose(self, rows: [&[f32; 4]; LANES]) -> [Self::F32s; 4] {
        array::from_fn(|column| rows.map(|row| row[column]))
    }

    #[inline(always)]
    fn with_any_bit(self, values: &[u32; LANES], bits: u32) -> u32 {
        Self::mask(|lane| values[lane] & bits != 0)
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{LANES, Simd, Task};

    /// Proof that the processor has AVX2: only [`run`] makes one.
    #[derive(Clone, Copy, Debug)]
    struct Avx2(());

    /// Runs a task, compiled for AVX2.
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn run<T: Task>(task: T) -> T::Output {
        task.run(Avx2(()))
    }

    // SAFETY of everything below: an `Avx2` is only there where the processor has the instructions, and loads and stores
    // are of whole arrays.
    impl Simd for Avx2 {
        type F32s = __m256;

        #[inline(always)]
        fn load(self, values: &[f32; LANES]) -> __m256 {
            unsafe { _mm256_loadu_ps(values.as_ptr()) }
        }

        #[inline(always)]
        fn splat(self, value: f32) -> __m256 {
            unsafe { _mm256_set1_ps(value) }
        }

        #[inline(always)]
        fn store(self, values: __m256) -> [f32; LANES] {
            let mut stored = [0.0; LANES];
            unsafe { _mm256_storeu_ps(stored.as_mut_ptr(), values) };
            stored
        }

        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            unsafe { _mm256_add_ps(a, b) }
        }

        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            unsafe { _mm256_sub_ps(a, b) }
        }

        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            unsafe { _mm256_mul_ps(a, b) }
        }

        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            unsafe { _mm256_min_ps(a, b) }
        }

        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            unsafe { _mm256_max_ps(a, b) }
        }

        #[inline(always)]
        fn le(self, a: __m256, b: __m256) -> u32 {
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32 }
        }

        #[inline(always)]
        fn lt(self, a: __m256, b: __m256) -> u32 {
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32 }
        }

        #[inline(always)]
        fn select(self, lanes: u32, values: __m256, otherwise: __m256) -> __m256 {
            unsafe {
                let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
                let chosen = _mm256_and_si256(_mm256_set1_epi32(lanes as i32), bits);
                let chosen = _mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, bits));
                _mm256_blendv_ps(otherwise, values, chosen)
            }
        }

        #[inline(always)]
        fn min_lane(self, values: __m256) -> f32 {
            unsafe {
                let fours = _mm_min_ps(_mm256_castps256_ps128(values), _mm256_extractf128_ps::<1>(values));
                let twos = _mm_min_ps(fours, _mm_movehl_ps(fours, fours));
                let one = _mm_min_ss(twos, _mm_shuffle_ps::<1>(twos, twos));
                _mm_cvtss_f32(one)
            }
        }

        #[inline(always)]
        fn tag(self, values: __m256, mask: u32, tags: &[u32; LANES]) -> __m256 {
            unsafe {
                let mask = _mm256_castsi256_ps(_mm256_set1_epi32(mask as i32));
                _mm256_or_ps(_mm256_andnot_ps(mask, values), _mm256_loadu_ps(tags.as_ptr().cast()))
            }
        }

        #[inline(always)]
        fn transpose(self, rows: [&[f32; 4]; LANES]) -> [__m256; 4] {
            unsafe {
                // Rows four apart share a register, so that lanes come out in the order of the rows.
                let pair = |row: usize| {
                    let low = _mm_loadu_ps(rows[row].as_ptr());
                    _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), _mm_loadu_ps(rows[row + 4].as_ptr()))
                };
                let (a, b, c, d) = (pair(0), pair(1), pair(2), pair(3));
                let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
                let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
                [
                    _mm256_shuffle_ps::<0x44>(ab, cd),
                    _mm256_shuffle_ps::<0xee>(ab, cd),
                    _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
                    _mm256_shuffle_ps::<0xee>(ab_high, cd_high),
                ]
            }
        }

        #[inline(always)]
        fn with_any_bit(self, values: &[u32; LANES], bits: u32) -> u32 {
            unsafe {
                let values = _mm256_loadu_si256(values.as_ptr().cast());
                let common = _mm256_and_si256(values, _mm256_set1_epi32(bits as i32));
                let none = _mm256_cmpeq_epi32(common, _mm256_setzero_si256());
                !_mm256_movemask_ps(_mm256_castsi256_ps(none)) as u32 & 0xff
            }
        }
    }
}
