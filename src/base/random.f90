!> Random numbers from a counter-based generator: Philox 4x32-10.
!>
!> J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as 1, 2,
!> 3", Proc. SC11 (2011). A block of 128 random bits is a bijection of a 128-bit counter under a
!> 64-bit key; there is no state that one number hands on to the next. The five integers that name a
!> stream stand as they are, 32 bits each, in the key and the counter:
!>
!>     key     = (seed, run)
!>     counter = (block number, case, satellite, instrument)
!>
!> A seed of more than 32 bits is h 2**32 + s with s from -2**31 to 2**31 - 1: s stands in the key; the low 30 bits
!> of h stand 2 bits up in the word of the satellite and the high 2 bits at the top of that of the instrument, where
!> a satellite from 0 to 3 and an instrument from 0 to 2**30 - 1 leave room. A seed of 32 bits has h = 0.
!>
!> Different names are different (key, counter) pairs for every block, so streams never overlap and
!> a stream's numbers depend on its name alone: not on threads, order, or which other streams are
!> drawn. A stream has 2**32 blocks, each good for two uniform or two normal numbers, and then
!> starts again.
!>
!> Blocks are made LANES at a time, each by the same instructions: the numbers do not depend on how many are drawn together.
module gracecg_base_random
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_lanes, only: LANES, lanes_logarithms, lanes_sines_cosines
    implicit none
    private
    public :: random_stream_t, new_stream, philox_4x32

    !> The stream of a name, with a seed of 32 or 64 bits
    interface new_stream
        module procedure new_stream_i4, new_stream_i8
    end interface new_stream

    integer(i8), parameter :: MASK = int(z'FFFFFFFF', i8)   !! The low 32 bits

    real(dp), parameter :: UNIFORM_STEP = 2.0_dp**(-53)

    !> One stream of random numbers. Copies go on independently from where they were made, with the
    !> same numbers.
    type :: random_stream_t
        private
        integer(i8) :: key(2) = 0           !! 32 bits in each
        integer(i8) :: counter(4) = 0       !! 32 bits in each; the first is the next block's number
        real(dp) :: spare_uniform = 0       !! Second uniform number of the last block
        real(dp) :: spare_normal = 0        !! Second normal number of the last block
        logical :: has_spare_uniform = .false.
        logical :: has_spare_normal = .false.
    contains
        procedure :: uniform    !! The next number uniform in (0, 1)
        procedure :: normal     !! The next normal number
        procedure :: normals    !! Many normal numbers
        procedure :: skip_normals   !! Goes on behind so many of them
    end type random_stream_t

contains

    !> The stream of this name, at its beginning. Every value of every argument is allowed; but with a seed of
    !> more than 32 bits streams are different for sure only where the satellite is 0 to 3 and the instrument 0 to
    !> 2**30 - 1.
    pure function new_stream_i8(seed, case_number, satellite, run, instrument) result(stream)
        integer(i8), intent(in) :: seed     !! The user's choice
        integer, intent(in) :: case_number  !! The case's own number
        integer, intent(in) :: satellite    !! 1: front, 2: back
        integer, intent(in) :: run          !! Number of the run
        integer, intent(in) :: instrument   !! What draws: one number for each source of errors
        type(random_stream_t) :: stream

        integer(i8), parameter :: HALF = int(z'80000000', i8)
        integer(i8) :: low, high

        low = ieor(iand(seed, MASK), HALF) - HALF       ! the low 32 bits, with their sign
        high = iand(shifta(seed, 32) + merge(1_i8, 0_i8, low < 0), MASK)
        stream%key = [iand(seed, MASK), word(run)]
        stream%counter = [0_i8, word(case_number), ieor(word(satellite), iand(shiftl(high, 2), MASK)), &
                          ieor(word(instrument), shiftl(shiftr(high, 30), 30))]
    end function new_stream_i8

    !> The same with a seed of 32 bits.
    pure function new_stream_i4(seed, case_number, satellite, run, instrument) result(stream)
        integer, intent(in) :: seed, case_number, satellite, run, instrument
        type(random_stream_t) :: stream

        stream = new_stream_i8(int(seed, i8), case_number, satellite, run, instrument)
    end function new_stream_i4

    !> The next number uniformly distributed in (0, 1): multiples of 2**-53, with 2**-54 for zero.
    real(dp) function uniform(self) result(u)
        class(random_stream_t), intent(inout) :: self

        integer(i8) :: word(LANES, 4)

        if (self%has_spare_uniform) then
            u = self%spare_uniform
        else
            call philox_4x32(self%counter, self%key, word)
            self%counter(1) = iand(self%counter(1) + 1, MASK)
            u = open_unit_interval(word(1, 1), word(1, 2))
            self%spare_uniform = open_unit_interval(word(1, 3), word(1, 4))
        end if
        self%has_spare_uniform = .not. self%has_spare_uniform
    end function uniform

    !> The next normally distributed number, mean 0 and variance 1.
    real(dp) function normal(self) result(x)
        class(random_stream_t), intent(inout) :: self

        real(dp) :: pair(2)

        if (self%has_spare_normal) then
            x = self%spare_normal
        else
            call next_normal_pairs(self, pair)
            x = pair(1)
            self%spare_normal = pair(2)
        end if
        self%has_spare_normal = .not. self%has_spare_normal
    end function normal

    !> Fills an array with normally distributed numbers: the same as that many calls of `normal`.
    subroutine normals(self, x)
        class(random_stream_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: x(:)   !! Mean 0, variance 1

        integer :: first, pairs

        if (size(x) == 0) return
        first = 1
        if (self%has_spare_normal) then
            x(1) = self%normal()
            first = 2
        end if
        pairs = (size(x) - first + 1)/2
        call next_normal_pairs(self, x(first:first + 2*pairs - 1))
        if (mod(size(x) - first, 2) == 0) x(size(x)) = self%normal()
    end subroutine normals

    !> Goes on as if so many normal numbers had been drawn, at once: a block is always two of them.
    subroutine skip_normals(self, count)
        class(random_stream_t), intent(inout) :: self
        integer(i8), intent(in) :: count    !! How many, >= 0

        integer(i8) :: left
        real(dp) :: passed_over

        left = count
        if (self%has_spare_normal .and. left > 0) then
            passed_over = self%normal()
            left = left - 1
        end if
        self%counter(1) = iand(self%counter(1) + left/2, MASK)
        if (mod(left, 2_i8) == 1) passed_over = self%normal()
    end subroutine skip_normals

    !> Two normal numbers from each of the next blocks: G. E. P. Box, M. E. Muller, Ann. Math. Statist. 29 (1958) 610-611.
    !> No number is rejected, so a block is always two numbers.
    pure subroutine next_normal_pairs(self, x)
        type(random_stream_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: x(:)   ! Mean 0, variance 1; an even count

        integer(i8) :: word(LANES, 4)
        real(dp), dimension(LANES) :: logarithm, radius, sines, cosines
        real(dp) :: numbers(2*LANES)
        integer :: i, n

        do i = 0, size(x) - 1, 2*LANES
            n = min(2*LANES, size(x) - i)
            call philox_4x32(self%counter, self%key, word)
            self%counter(1) = iand(self%counter(1) + n/2, MASK)
            call lanes_logarithms(open_unit_interval(word(:, 1), word(:, 2)), logarithm)
            call lanes_sines_cosines(open_unit_interval(word(:, 3), word(:, 4)), sines, cosines)
            radius = sqrt(-2*logarithm)
            numbers(1::2) = radius*cosines
            numbers(2::2) = radius*sines
            x(i + 1:i + n) = numbers(:n)
        end do
    end subroutine next_normal_pairs

    !> A number in (0, 1) from two 32-bit words: 53 of their 64 bits.
    elemental real(dp) function open_unit_interval(high, low) result(u)
        integer(i8), intent(in) :: high, low

        u = max(0.5_dp, real(ior(shiftl(high, 21), shiftr(low, 11)), dp))*UNIFORM_STEP
    end function open_unit_interval

    !> Blocks of Philox 4x32-10 from a counter on: 128 random bits each of a counter and a key. The rounds stand inside the
    !> loop over the blocks: so the compiler holds LANES of them in registers.
    pure subroutine philox_4x32(counter, key, word)
        integer(i8), intent(in) :: counter(4)       !! Words of 32 bits, 0 to 2**32 - 1, of the first block
        integer(i8), intent(in) :: key(2)           !! Words of 32 bits
        integer(i8), intent(out) :: word(LANES, 4)  !! Of 32 bits; block, place

        integer, parameter :: ROUNDS = 10
        ! Table 2 of the paper. Multipliers are less by 2**32: so a product does not overflow, and its high word is less by
        ! what was multiplied.
        integer(i8), parameter :: MULTIPLIER(2) = [int(z'D2511F53', i8), int(z'CD9E8D57', i8)] - 2_i8**32
        integer(i8), parameter :: INCREMENT(2) = [int(z'9E3779B9', i8), int(z'BB67AE85', i8)]
        integer(i8) :: keys(2, ROUNDS), a, b, c, d, first, second, high_first, high_second
        integer :: i, lane

        do i = 1, ROUNDS
            keys(:, i) = iand(key + (i - 1)*INCREMENT, MASK)
        end do
        do lane = 1, LANES
            a = iand(counter(1) + lane - 1, MASK)
            b = counter(2)
            c = counter(3)
            d = counter(4)
            do i = 1, ROUNDS
                first = a*MULTIPLIER(1)
                second = c*MULTIPLIER(2)
                high_first = shifta(first, 32) + a
                high_second = shifta(second, 32) + c
                a = ieor(ieor(high_second, b), keys(1, i))
                b = iand(second, MASK)
                c = ieor(ieor(high_first, d), keys(2, i))
                d = iand(first, MASK)
            end do
            word(lane, :) = [a, b, c, d]
        end do
    end subroutine philox_4x32

    !> The 32 bits of an integer as a word from 0 to 2**32 - 1.
    pure integer(i8) function word(number)
        integer, intent(in) :: number

        word = iand(int(number, i8), MASK)
    end function word
end module gracecg_base_random
