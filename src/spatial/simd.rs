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
    /// Eight `u32`.
    type U32s: Copy;

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

    fn div(self, a: Self::F32s, b: Self::F32s) -> Self::F32s;
    /// The least whole numbers that are not less.
    fn ceil(self, values: Self::F32s) -> Self::F32s;
    /// The whole parts of values from 0 to 2^31.
    fn whole(self, values: Self::F32s) -> Self::U32s;
    /// The bits of the values.
    fn bits(self, values: Self::F32s) -> Self::U32s;
    /// The values of the bits.
    fn floats(self, bits: Self::U32s) -> Self::F32s;
    /// The first values of all columns, the second ones, and so on: undoes [`transpose`](Self::transpose).
    fn rows(self, columns: [Self::F32s; 4]) -> [[f32; 4]; LANES];
    /// All bits in the lanes in which `a < b`.
    fn lt_lanes(self, a: Self::F32s, b: Self::F32s) -> Self::U32s;
    /// `values` in the lanes that have all bits, and `otherwise` in those that have none.
    fn blend(self, lanes: Self::U32s, values: Self::F32s, otherwise: Self::F32s) -> Self::F32s;
    /// The same for bits.
    fn select_bits(self, lanes: Self::U32s, values: Self::U32s, otherwise: Self::U32s) -> Self::U32s;
    fn load_bits(self, values: &[u32; LANES]) -> Self::U32s;
    fn splat_bits(self, value: u32) -> Self::U32s;
    fn store_bits(self, values: Self::U32s) -> [u32; LANES];
    fn and(self, a: Self::U32s, b: Self::U32s) -> Self::U32s;
    fn or(self, a: Self::U32s, b: Self::U32s) -> Self::U32s;
    /// `a & !b`.
    fn and_not(self, a: Self::U32s, b: Self::U32s) -> Self::U32s;
    /// All bits in the lanes in which `a == b`.
    fn eq_bits(self, a: Self::U32s, b: Self::U32s) -> Self::U32s;
    /// The lanes whose highest bit is set.
    fn high_bits(self, values: Self::U32s) -> u32;
    /// So many of the lowest bits: none below one, and all from 32 on. No count may be NaN.
    fn low_bits(self, counts: Self::F32s) -> Self::U32s;
    /// Eight rows of four bytes, cut into two blocks of four rows: of each block the first bytes of its rows in one
    /// lane, the second ones in the next, and so on.
    fn blocks_of_rows(self, rows: Self::U32s) -> Self::U32s;
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
    type U32s = [u32; LANES];

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

    #[inline(always)]
    fn div(self, a: Self::F32s, b: Self::F32s) -> Self::F32s {
        Self::zip(a, b, |a, b| a / b)
    }

    #[inline(always)]
    fn ceil(self, values: Self::F32s) -> Self::F32s {
        values.map(f32::ceil)
    }

    #[inline(always)]
    fn whole(self, values: Self::F32s) -> Self::U32s {
        values.map(|value| value as u32)
    }

    #[inline(always)]
    fn bits(self, values: Self::F32s) -> Self::U32s {
        values.map(f32::to_bits)
    }

    #[inline(always)]
    fn floats(self, bits: Self::U32s) -> Self::F32s {
        bits.map(f32::from_bits)
    }

    #[inline(always)]
    fn rows(self, columns: [Self::F32s; 4]) -> [[f32; 4]; LANES] {
        array::from_fn(|lane| columns.map(|column| column[lane]))
    }

    #[inline(always)]
    fn lt_lanes(self, a: Self::F32s, b: Self::F32s) -> Self::U32s {
        array::from_fn(|lane| if a[lane] < b[lane] { u32::MAX } else { 0 })
    }

    #[inline(always)]
    fn blend(self, lanes: Self::U32s, values: Self::F32s, otherwise: Self::F32s) -> Self::F32s {
        array::from_fn(|lane| {
            if lanes[lane] != 0 {
                values[lane]
            } else {
                otherwise[lane]
            }
        })
    }

    #[inline(always)]
    fn select_bits(self, lanes: Self::U32s, values: Self::U32s, otherwise: Self::U32s) -> Self::U32s {
        array::from_fn(|lane| {
            if lanes[lane] != 0 {
                values[lane]
            } else {
                otherwise[lane]
            }
        })
    }

    #[inline(always)]
    fn load_bits(self, values: &[u32; LANES]) -> Self::U32s {
        *values
    }

    #[inline(always)]
    fn splat_bits(self, value: u32) -> Self::U32s {
        [value; LANES]
    }

    #[inline(always)]
    fn store_bits(self, values: Self::U32s) -> [u32; LANES] {
        values
    }

    #[inline(always)]
    fn and(self, a: Self::U32s, b: Self::U32s) -> Self::U32s {
        array::from_fn(|lane| a[lane] & b[lane])
    }

    #[inline(always)]
    fn or(self, a: Self::U32s, b: Self::U32s) -> Self::U32s {
        array::from_fn(|lane| a[lane] | b[lane])
    }

    #[inline(always)]
    fn and_not(self, a: Self::U32s, b: Self::U32s) -> Self::U32s {
        array::from_fn(|lane| a[lane] & !b[lane])
    }

    #[inline(always)]
    fn eq_bits(self, a: Self::U32s, b: Self::U32s) -> Self::U32s {
        array::from_fn(|lane| if a[lane] == b[lane] { u32::MAX } else { 0 })
    }

    #[inline(always)]
    fn high_bits(self, values: Self::U32s) -> u32 {
        Self::mask(|lane| values[lane] >> 31 != 0)
    }

    #[inline(always)]
    fn low_bits(self, counts: Self::F32s) -> Self::U32s {
        counts.map(|count| {
            let count = count.clamp(0.0, 32.0) as u32;
            u32::MAX.checked_shl(count).map_or(u32::MAX, |above| !above)
        })
    }

    #[inline(always)]
    fn blocks_of_rows(self, rows: Self::U32s) -> Self::U32s {
        array::from_fn(|lane| {
            let (block, byte) = (lane / 4, lane % 4);
            u32::from_le_bytes(array::from_fn(|row| rows[4 * block + row].to_le_bytes()[byte]))
        })
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
        type U32s = __m256i;

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

        #[inline(always)]
        fn div(self, a: __m256, b: __m256) -> __m256 {
            unsafe { _mm256_div_ps(a, b) }
        }

        #[inline(always)]
        fn ceil(self, values: __m256) -> __m256 {
            unsafe { _mm256_ceil_ps(values) }
        }

        #[inline(always)]
        fn whole(self, values: __m256) -> __m256i {
            unsafe { _mm256_cvttps_epi32(values) }
        }

        #[inline(always)]
        fn bits(self, values: __m256) -> __m256i {
            unsafe { _mm256_castps_si256(values) }
        }

        #[inline(always)]
        fn floats(self, bits: __m256i) -> __m256 {
            unsafe { _mm256_castsi256_ps(bits) }
        }

        #[inline(always)]
        fn rows(self, columns: [__m256; 4]) -> [[f32; 4]; LANES] {
            unsafe {
                let [x, y, z, w] = columns;
                let (xz, yw) = (_mm256_unpacklo_ps(x, z), _mm256_unpacklo_ps(y, w));
                let (xz_high, yw_high) = (_mm256_unpackhi_ps(x, z), _mm256_unpackhi_ps(y, w));
                // Rows four apart share a register.
                let pairs = [
                    _mm256_unpacklo_ps(xz, yw),
                    _mm256_unpackhi_ps(xz, yw),
                    _mm256_unpacklo_ps(xz_high, yw_high),
                    _mm256_unpackhi_ps(xz_high, yw_high),
                ];
                let mut rows = [[0.0; 4]; LANES];
                for (row, pair) in pairs.into_iter().enumerate() {
                    _mm_storeu_ps(rows[row].as_mut_ptr(), _mm256_castps256_ps128(pair));
                    _mm_storeu_ps(rows[row + 4].as_mut_ptr(), _mm256_extractf128_ps::<1>(pair));
                }
                rows
            }
        }

        #[inline(always)]
        fn lt_lanes(self, a: __m256, b: __m256) -> __m256i {
            unsafe { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) }
        }

        #[inline(always)]
        fn blend(self, lanes: __m256i, values: __m256, otherwise: __m256) -> __m256 {
            unsafe { _mm256_blendv_ps(otherwise, values, _mm256_castsi256_ps(lanes)) }
        }

        #[inline(always)]
        fn select_bits(self, lanes: __m256i, values: __m256i, otherwise: __m256i) -> __m256i {
            unsafe { _mm256_blendv_epi8(otherwise, values, lanes) }
        }

        #[inline(always)]
        fn load_bits(self, values: &[u32; LANES]) -> __m256i {
            unsafe { _mm256_loadu_si256(values.as_ptr().cast()) }
        }

        #[inline(always)]
        fn splat_bits(self, value: u32) -> __m256i {
            unsafe { _mm256_set1_epi32(value as i32) }
        }

        #[inline(always)]
        fn store_bits(self, values: __m256i) -> [u32; LANES] {
            let mut stored = [0; LANES];
            unsafe { _mm256_storeu_si256(stored.as_mut_ptr().cast(), values) };
            stored
        }

        #[inline(always)]
        fn and(self, a: __m256i, b: __m256i) -> __m256i {
            unsafe { _mm256_and_si256(a, b) }
        }

        #[inline(always)]
        fn or(self, a: __m256i, b: __m256i) -> __m256i {
            unsafe { _mm256_or_si256(a, b) }
        }

        #[inline(always)]
        fn and_not(self, a: __m256i, b: __m256i) -> __m256i {
            unsafe { _mm256_andnot_si256(b, a) }
        }

        #[inline(always)]
        fn eq_bits(self, a: __m256i, b: __m256i) -> __m256i {
            unsafe { _mm256_cmpeq_epi32(a, b) }
        }

        #[inline(always)]
        fn high_bits(self, values: __m256i) -> u32 {
            unsafe { _mm256_movemask_ps(_mm256_castsi256_ps(values)) as u32 }
        }

        #[inline(always)]
        fn low_bits(self, counts: __m256) -> __m256i {
            unsafe {
                let counts = _mm256_min_ps(_mm256_max_ps(counts, _mm256_setzero_ps()), _mm256_set1_ps(32.0));
                let all = _mm256_set1_epi32(-1);
                // A shift by 32 leaves no bit.
                _mm256_andnot_si256(_mm256_sllv_epi32(all, _mm256_cvttps_epi32(counts)), all)
            }
        }

        #[inline(always)]
        fn blocks_of_rows(self, rows: __m256i) -> __m256i {
            unsafe {
                let order = _mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
                _mm256_shuffle_epi8(rows, _mm256_broadcastsi128_si256(order))
            }
        }
    }
}
