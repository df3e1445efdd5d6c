!> What a Level-1 file holds, found in one pass with constant memory: times, intervals, gaps, flags, and for
!> each field how many values there are, the first, the last, mean, least and greatest.
module gracecg_level1_summary
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_level1_basics
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    implicit none
    private
    public :: level1_summary_t, field_summary_t, summarise_level1, GAP_INTERVALS

    real(dp), parameter :: GAP_INTERVALS = 1.5_dp   !! A longer step than so many usual intervals is a gap
    integer, parameter :: FIRST_STEPS = 501               !! The first ones, whose median is the usual interval
    integer, parameter :: MOST_SERIES = 64          !! Heads, gyros, tanks or forms of record in one file

    type :: field_summary_t
        !! Values of one field
        integer(i8) :: count = 0                    !! Records that have it
        real(dp) :: first = 0, last = 0             !! Of the records in the order of the file
        real(dp) :: total = 0, rest = 0             !! Sum, and what was lost of it by rounding
        real(dp) :: least = 0, greatest = 0    !! Of the finite values
    contains
        procedure :: mean => mean_of_field          !! Of all values
    end type field_summary_t

    type :: level1_summary_t
        !! What a file holds
        character(:), allocatable :: path               !! Of the file
        type(level1_header_t) :: header                 !! What the header says
        type(level1_layout_t) :: layout                 !! The fields of the records
        character(1) :: satellite = ''                  !! By the records; without any by header or name
        type(string_t), allocatable :: warnings(:)      !! What is unusual, but no failure
        integer(i8) :: records = 0    !! That could be read
        integer(i8) :: first_seconds = 0, last_seconds = 0      !! Of the first and the last record of the file
        real(dp) :: first_fraction = 0, last_fraction = 0       !! s
        real(dp) :: interval = 0                        !! Mean of the steps of one series that are no gaps, s; 0: none
        integer(i8) :: gaps = 0                         !! Steps longer than GAP_INTERVALS usual ones
        integer(i8) :: duplicates = 0                   !! Records with the epoch of the one before, in one series
        integer(i8) :: unsorted = 0                     !! Records earlier than the one before, in one series
        integer(i8) :: flags(0:7) = 0                   !! Records with each bit of qualflg set
        type(field_summary_t), allocatable :: fields(:) !! By field of the layout
    end type level1_summary_t

contains

    !> Reads a file to its end. Fails where it is broken.
    subroutine summarise_level1(path, summary, error, with_fields)
        character(*), intent(in) :: path            !! Of the file
        type(level1_summary_t), intent(out) :: summary
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in) :: with_fields          !! The fields too

        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        real(dp) :: keys(MOST_SERIES), fraction(MOST_SERIES), steps(FIRST_STEPS), usual, total
        integer(i8) :: seconds(MOST_SERIES), counted
        integer :: series, collected, i, field, bit

        call reader%open(path, error)
        if (allocated(error)) return
        summary%path = reader%path
        summary%header = reader%header
        summary%layout = reader%layout
        allocate (summary%fields(size(summary%layout%fields)))
        series = 0
        collected = 0
        total = 0
        counted = 0
        do
            call reader%next(block, error)
            if (allocated(error)) return
            if (block%count == 0) exit
            associate (n => block%count, values => block%values, layout => summary%layout)
                if (summary%records == 0) then
                    summary%first_seconds = block%seconds(1)
                    summary%first_fraction = block%fraction(1)
                end if
                summary%last_seconds = block%seconds(n)
                summary%last_fraction = block%fraction(n)
                summary%records = summary%records + n
                do i = 1, n
                    call take_tag(i)
                end do
                if (layout%qualflg > 0) summary%flags = summary%flags + &
                    [(count(btest(int(values(:n, layout%qualflg)), bit)), bit=0, 7)]
                if (.not. with_fields) cycle
                do field = 1, size(summary%fields)
                    call add_values(values(:n, field), summary%fields(field))
                end do
            end associate
        end do
        if (collected < FIRST_STEPS) call take_first_steps()
        if (counted > 0) summary%interval = total/real(counted, dp)
        summary%satellite = reader%satellite
        summary%warnings = reader%warnings

    contains

        !> The tag of record i, behind the last one of its series.
        subroutine take_tag(i)
            integer, intent(in) :: i

            real(dp) :: key, step
            integer :: k

            key = 0
            if (summary%layout%series > 0) key = block%values(i, summary%layout%series)
            do k = 1, series
                if (abs(keys(k) - key) <= 0) exit
            end do
            if (k > series) then
                series = min(series + 1, MOST_SERIES)
                k = series
                keys(k) = key
            else
                step = real(block%seconds(i) - seconds(k), dp) + (block%fraction(i) - fraction(k))
                if (step < 0) then
                    summary%unsorted = summary%unsorted + 1
                else if (step <= 0) then
                    summary%duplicates = summary%duplicates + 1
                else if (collected < FIRST_STEPS) then
                    collected = collected + 1
                    steps(collected) = step
                    if (collected == FIRST_STEPS) call take_first_steps()
                else
                    call take_step(step)
                end if
            end if
            seconds(k) = block%seconds(i)
            fraction(k) = block%fraction(i)
        end subroutine take_tag

        !> The usual interval is the median of the first steps.
        subroutine take_first_steps()
            integer :: j

            if (collected == 0) return
            usual = median_of(steps(:collected))
            do j = 1, collected
                call take_step(steps(j))
            end do
        end subroutine take_first_steps

        subroutine take_step(step)
            real(dp), intent(in) :: step

            if (step > GAP_INTERVALS*usual .and. .not. summary%layout%is_event) then
                summary%gaps = summary%gaps + 1
            else
                total = total + step
                counted = counted + 1
            end if
        end subroutine take_step
    end subroutine summarise_level1

    !> Adds values to a summary; the sum is exact to rounding at its end (A. Neumaier, ZAMM 54 (1974) 39).
    pure subroutine add_values(values, field)
        real(dp), intent(in) :: values(:)
        type(field_summary_t), intent(inout) :: field

        real(dp) :: sum
        integer :: i

        do i = 1, size(values)
            if (ieee_is_nan(values(i))) cycle
            if (field%count == 0) then
                field%first = values(i)
                field%least = values(i)
                field%greatest = values(i)
            end if
            field%count = field%count + 1
            field%last = values(i)
            field%least = min(field%least, values(i))
            field%greatest = max(field%greatest, values(i))
            sum = field%total + values(i)
            if (abs(field%total) >= abs(values(i))) then
                field%rest = field%rest + ((field%total - sum) + values(i))
            else
                field%rest = field%rest + ((values(i) - sum) + field%total)
            end if
            field%total = sum
        end do
    end subroutine add_values

    !> The mean of all values; 0 of none.
    elemental real(dp) function mean_of_field(self) result(mean)
        class(field_summary_t), intent(in) :: self

        mean = 0
        if (self%count > 0) mean = (self%total + self%rest)/real(self%count, dp)
    end function mean_of_field
end module gracecg_level1_summary
