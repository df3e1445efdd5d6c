!> The moments of the torque rods as a series that was measured: what flew, not what was commanded.
!>
!> Between the samples each rod has the cubic of Hermite through two of them, whose slopes are those of the
!> polynomial through the five nearest ones: continuous with its first derivative, and for a smooth moment
!> with an error of h^4/384 times its fourth derivative, h the spacing (a sine of 0.1 Hz: 4e-8 of its
!> amplitude at 10 samples a second, 7e-4 at one).
!>
!> Moments may be held from sample to sample, too: then they are steps. Of torquers, which stand in for rods, the samples are
!> torques in N m.
module gracecg_spacecraft_moment_series
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_statistics, only: median_of
    use gracecg_base_text, only: integer_text
    implicit none
    private
    public :: moment_series_t, new_moment_series, has_moments, series_moments, check_moments_cover, median_spacing
    public :: FEWEST_MOMENTS, interchange_series, part_of_series

    integer, parameter :: FEWEST_MOMENTS = 5            !! Samples, for a slope
    real(dp), parameter :: LARGEST_MOMENT = 300         !! Ten times what a rod bears: beyond, it is another unit, A m^2
    real(dp), parameter :: LONGEST_GAP = 2.5_dp         !! Between samples, in units of their median spacing

    !> Samples of the moments; without any, nothing was measured.
    type :: moment_series_t
        real(dp), allocatable :: time(:)        !! (n), increasing, s from the epoch
        real(dp), allocatable :: moment(:, :)   !! (3, n), along the rods x, y, z, A m^2
        logical :: held = .false.               !! From sample to sample; else smooth
        logical :: direct = .false.             !! Torques, N m
        real(dp), allocatable, private :: slope(:, :)   !! (3, n), A m^2/s
    end type moment_series_t

contains

    !> A series of samples, smooth or held. Fails when there are too few, when times do not increase or leave a gap, and when
    !> a number is not finite or too large for a moment in A m^2.
    subroutine new_moment_series(time, moment, self, error, held, direct)
        type(moment_series_t), intent(out) :: self
        real(dp), intent(in) :: time(:)         !! s
        real(dp), intent(in) :: moment(:, :)    !! (3, size(time)), A m^2
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: held   !! From sample to sample; absent: smooth
        logical, intent(in), optional :: direct !! Torques, N m; absent: moments of rods

        integer :: i

        if (present(direct)) self%direct = direct
        call check_samples(trim(name_of(self))//' ', time, moment, error)
        if (allocated(error)) return
        if (present(held)) self%held = held
        self%time = time
        self%moment = moment
        allocate (self%slope(3, size(time)))
        do i = 1, size(time)
            self%slope(:, i) = slope_at(time, moment, i)
        end do
    end subroutine new_moment_series

    !> What was measured of two rods, each taken for the other.
    pure subroutine interchange_series(self, first, second)
        type(moment_series_t), intent(inout) :: self
        integer, intent(in) :: first, second    !! Axes, 1 to 3

        if (.not. has_moments(self)) return
        self%moment([first, second], :) = self%moment([second, first], :)
        self%slope([first, second], :) = self%slope([second, first], :)
    end subroutine interchange_series

    !> The samples that an interval of time needs, with a margin, and the slopes they had: within the interval the
    !> moments are those of the whole series. Times count from its beginning.
    pure subroutine part_of_series(self, from, to, reach, part)
        type(moment_series_t), intent(in) :: self
        real(dp), intent(in) :: from, to            !! s
        real(dp), intent(in) :: reach               !! By which it is asked for earlier, or later; s
        type(moment_series_t), intent(out) :: part  !! Nothing measured, if nothing was

        integer :: first, last

        if (.not. has_moments(self)) return
        ! as many on either side as make a series, too, at an end of it or where samples are missing
        first = max(1, interval_before(self%time, from - reach) - FEWEST_MOMENTS)
        last = min(size(self%time), interval_before(self%time, to + reach) + 1 + FEWEST_MOMENTS)
        part%held = self%held
        part%direct = self%direct
        part%time = self%time(first:last) - from
        part%moment = self%moment(:, first:last)
        part%slope = self%slope(:, first:last)
    end subroutine part_of_series

    !> The number of the sample before a time, or of the interval at an end that is nearest to it.
    pure integer function interval_before(time, t) result(low)
        real(dp), intent(in) :: time(:)     !! Increasing, s
        real(dp), intent(in) :: t           !! s

        low = max(1, min(size(time) - 1, last_not_after(time, t)))
    end function interval_before

    !> What a series is of, for messages, with blanks behind it.
    pure function name_of(self) result(name)
        type(moment_series_t), intent(in) :: self
        character(28) :: name

        name = 'moments of the torque rods:'
        if (self%direct) name = 'torques:'
    end function name_of

    subroutine check_samples(name, time, moment, error)
        character(*), intent(in) :: name
        real(dp), intent(in) :: time(:), moment(:, :)
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: unit
        real(dp) :: spacing
        integer :: i

        unit = ' A m^2'
        if (name(:7) == 'torques') unit = ' N m'
        if (size(time) /= size(moment, 2)) then
            call fail(error, name//integer_text(size(time))//' time tags, but '//integer_text(size(moment, 2))//' samples')
        else if (size(time) < FEWEST_MOMENTS) then
            call fail(error, name//integer_text(size(time))//' samples, at least '//integer_text(FEWEST_MOMENTS)// &
                      ' are needed')
        end if
        if (allocated(error)) return
        do i = 1, size(time)
            if (.not. abs(time(i)) <= huge(1.0_dp)) then
                call fail(error, name//'time tag '//integer_text(i)//' is NaN or infinite')
            else if (.not. all(abs(moment(:, i)) <= huge(1.0_dp))) then
                call fail(error, name//'the sample at '//number_text(time(i))//' s is NaN or infinite')
            else if (.not. all(abs(moment(:, i)) <= LARGEST_MOMENT)) then
                call fail(error, name//'the sample at '//number_text(time(i))//' s has a component of '// &
                          number_text(maxval(abs(moment(:, i))))//unit//', more than '//number_text(LARGEST_MOMENT)// &
                          unit//'; samples have to be in'//unit)
            else if (i > 1) then
                if (.not. time(i) > time(i - 1)) &
                    call fail(error, name//'time tags must increase, but '//number_text(time(i))//' s follows '// &
                              number_text(time(i - 1))//' s')
            end if
            if (allocated(error)) return
        end do
        spacing = median_spacing(time)
        do i = 2, size(time)
            if (time(i) - time(i - 1) <= LONGEST_GAP*spacing) cycle
            call fail(error, name//'no samples between '//number_text(time(i - 1))//' s and '//number_text(time(i))// &
                      ' s, where others are '//number_text(spacing)//' s apart: what was done there is not known')
            return
        end do
    end subroutine check_samples

    !> The usual distance of increasing times.
    pure real(dp) function median_spacing(time)
        real(dp), intent(in) :: time(:)     !! At least two, s

        median_spacing = median_of(time(2:) - time(:size(time) - 1))
    end function median_spacing

    !> The slope at sample i of the polynomial through the FEWEST_MOMENTS nearest samples, by Lagrange's formula.
    pure function slope_at(time, moment, i) result(slope)
        real(dp), intent(in) :: time(:), moment(:, :)
        integer, intent(in) :: i
        real(dp) :: slope(3)

        real(dp) :: weight
        integer :: first, last, j, k

        first = max(1, min(size(time) - FEWEST_MOMENTS + 1, i - FEWEST_MOMENTS/2))
        last = first + FEWEST_MOMENTS - 1
        slope = 0
        do j = first, last
            if (j == i) cycle
            weight = 1/(time(j) - time(i))
            do k = first, last
                if (k /= i .and. k /= j) weight = weight*(time(i) - time(k))/(time(j) - time(k))
            end do
            slope = slope + weight*(moment(:, j) - moment(:, i))
        end do
    end function slope_at

    !> Were the moments measured?
    pure logical function has_moments(self)
        type(moment_series_t), intent(in) :: self

        has_moments = allocated(self%time)
    end function has_moments

    !> The moments along the rods x, y, z at a time, A m^2. Before the first sample and after the last one the
    !> cubic goes on for one spacing; further out the moments stay. Those that are held as what is to be integrated: a step
    !> lasts STEP_LENGTH, u - sin(2 pi u)/(2 pi) with u from 0 to 1. Its rate has nothing at multiples of 10 Hz, so that Runge-Kutta
    !> steps of 0.1 s, with their weights 1, 4, 1, integrate it exactly, wherever they lie.
    pure function series_moments(self, t, at_once) result(moment)
        type(moment_series_t), intent(in) :: self   !! That has samples
        real(dp), intent(in) :: t                   !! s
        logical, intent(in), optional :: at_once    !! Those that are held jump, as they are
        real(dp) :: moment(3)

        real(dp), parameter :: STEP_LENGTH = 0.2_dp     ! s
        real(dp) :: h, u
        integer :: low

        if (self%held) then
            if (present(at_once)) then
                moment = self%moment(:, max(1, last_not_after(self%time, t)))
                if (at_once) return
            end if
            low = max(2, last_not_after(self%time, t + STEP_LENGTH/2))
            u = max(0.0_dp, min(1.0_dp, (t - self%time(low))/STEP_LENGTH + 0.5_dp))
            moment = self%moment(:, low - 1) + (u - sin(TWO_PI*u)/TWO_PI)*(self%moment(:, low) - self%moment(:, low - 1))
            return
        end if
        low = interval_before(self%time, t)
        h = self%time(low + 1) - self%time(low)
        u = min(2.0_dp, max(-1.0_dp, (t - self%time(low))/h))
        moment = self%moment(:, low) + u**2*(3 - 2*u)*(self%moment(:, low + 1) - self%moment(:, low)) + &
                 h*u*(u - 1)*((u - 1)*self%slope(:, low) + u*self%slope(:, low + 1))
    end function series_moments

    !> Fails unless a series reaches, to one spacing, from 0 to the end of an arc.
    subroutine check_moments_cover(self, duration, error)
        type(moment_series_t), intent(in) :: self   !! That has samples
        real(dp), intent(in) :: duration            !! s
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: reach

        reach = 1.01_dp*median_spacing(self%time)
        associate (first => self%time(1), last => self%time(size(self%time)))
            if (first > reach .or. last < duration - reach) &
                call fail(error, trim(name_of(self))//' samples from '//number_text(first)//' s to '// &
                          number_text(last)//' s do not cover the arc from 0 to '//number_text(duration)//' s')
        end associate
    end subroutine check_moments_cover
end module gracecg_spacecraft_moment_series
