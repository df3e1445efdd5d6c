!> The numbers that tell whether a day of Level-1 data was understood, each with the range that such data have.
module gracecg_level1_check_rows
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_records, only: level1_records_t, read_level1
    implicit none
    private
    public :: level1_check_t, check_row_t, without_line, slope_of

    integer, parameter :: MOST_RECORDS = 100000     !! Of a product: more are not looked at

    type :: check_row_t
        !! One number
        character(32) :: quantity = ''              !! Name
        real(dp) :: value = 0    !! In `unit`
        character(16) :: unit = ''                  !! Of the value; blank: none
        real(dp) :: allowed(2) = 0                  !! What such data have
    contains
        procedure :: is_usual                       !! The value is within
    end type check_row_t

    type :: level1_check_t
        !! All that was found
        type(check_row_t), allocatable :: rows(:)    !! The numbers
        type(string_t), allocatable :: warnings(:)  !! What could not be looked at, and what files say
        type(level1_folder_t) :: files              !! That are looked at
        type(error_t), allocatable :: failure       !! The first one: nothing is read behind it
    contains
        procedure :: add                            !! One more number
        procedure :: add_axes                       !! Three more, by axis
        procedure :: note                           !! One more warning, said once
        procedure :: take                           !! Reads a product
    end type level1_check_t

contains

    elemental logical function is_usual(self)
        class(check_row_t), intent(in) :: self

        is_usual = self%value >= self%allowed(1) .and. self%value <= self%allowed(2)
    end function is_usual

    subroutine add(self, quantity, value, unit, low, high)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: quantity, unit      !! Name and unit of the number
        real(dp), intent(in) :: value, low, high        !! The number, and the range in which it is as it should be

        self%rows = [self%rows, check_row_t(quantity, value, unit, [low, high])]
    end subroutine add

    subroutine add_axes(self, quantity, values, unit, low, high)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: quantity, unit      !! The axis follows behind _
        real(dp), intent(in) :: values(3), low, high    !! Of x, y, z, and the range of each

        integer :: i

        do i = 1, 3
            call self%add(quantity//'_'//AXES(i), values(i), unit, low, high)
        end do
    end subroutine add_axes

    subroutine note(self, text)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: text    !! A warning; the same is kept once

        integer :: i

        do i = 1, size(self%warnings)
            if (self%warnings(i)%text == text) return
        end do
        call append(self%warnings, text)
    end subroutine note

    !> Reads the files of a product, as far as they are looked at.
    subroutine take(self, product, records)
        class(level1_check_t), intent(inout) :: self
        character(5), intent(in) :: product                 !! 'ACC1A'
        type(level1_records_t), intent(out) :: records      !! None without files, and after a failure

        type(string_t), allocatable :: paths(:)
        integer :: i

        if (allocated(self%failure)) return
        call self%files%paths_of(product, paths)
        if (size(paths) == 0) return
        call read_level1(paths, records, self%failure, most=MOST_RECORDS)
        if (allocated(self%failure)) then
            records%count = 0
            return
        end if
        do i = 1, size(records%warnings)
            call self%note(product//': '//records%warnings(i)%text)
        end do
        if (records%count >= MOST_RECORDS) &
            call self%note(product//': the first '//integer_text(records%count)//' records are looked at')
    end subroutine take

    !> Values less the straight line through them.
    pure function without_line(times, values) result(rest)
        real(dp), intent(in) :: times(:), values(:)     !! s, anything
        real(dp) :: rest(size(values))

        rest = values - sum(values)/size(values) - slope_of(times, values)*(times - sum(times)/size(times))
    end function without_line

    !> The slope of the straight line through some values.
    pure real(dp) function slope_of(times, values) result(slope)
        real(dp), intent(in) :: times(:), values(:)     !! s, anything

        real(dp) :: t(size(times))

        t = times - sum(times)/size(times)
        slope = dot_product(t, values - sum(values)/size(values))/max(dot_product(t, t), tiny(1.0_dp))
    end function slope_of
end module gracecg_level1_check_rows
