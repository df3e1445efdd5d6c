!> The files of a product in a folder of Level-1 files, and their records in GPS time.
module gracecg_level1_product_reading
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, integer_text
    use gracecg_level1_header, only: name_of
    use gracecg_level1_setup, only: origin_t
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_time, only: level1_clock_t, to_gps_time
    use gracecg_level1_calibration, only: level1_calibration_t, note
    implicit none
    private
    public :: find_files, read_product, note_product, without_bits

    !> What products give, by the letters that they begin with
    character(3), parameter :: FAMILIES(11) = ['ACC', 'MAG', 'SCA', 'QSA', 'IMU', 'GNI', 'GNV', 'THR', 'CLK', 'TIM', 'MAS']
    character(40), parameter :: GIVES(11) = [character(40) :: 'accelerations', 'currents of the rods, measured field', &
        'attitude', 'axes of the star cameras', 'angles of the gyros', 'orbit, inertial', 'orbit, Earth-fixed', &
        'firings of thrusters', 'GPS less receiver time', 'receiver less on-board time', 'masses']

contains

    !> The files of one of some products, on every day that has one: the first product that is there on as many days as
    !> any of them.
    subroutine find_files(files, products, paths)
        type(level1_folder_t), intent(in) :: files
        character(5), intent(in) :: products(:)    !! Names of products, the preferred first
        type(string_t), allocatable, intent(out) :: paths(:)    !! In order of the days; none: there is none

        integer :: i

        i = maxloc([(files%days_with(products(i)), i=1, size(products))], 1)
        call files%paths_of(products(i), paths)
    end subroutine find_files

    !> Reads the wanted fields of a product in GPS time.
    subroutine read_product(paths, clock, calibration, fields, records, error, windows)
        type(string_t), intent(in) :: paths(:)
        character(*), intent(in) :: fields(:)               !! Their names
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: windows(:, :)     !! (2, n), s past 2000-01-01 12:00; absent: all

        integer :: extrapolated, i

        call read_level1(paths, records, error, fields, windows)
        if (allocated(error)) return
        call note_product(calibration, records%layout%product, paths)
        if (records%count == 0) return
        if (records%satellite /= calibration%satellite) then
            call fail(error, records%path//': its records are of satellite '//records%satellite//', not '// &
                      calibration%satellite)
            return
        end if
        if (records%layout%product(5:5) == 'A' .and. records%time_ref == 'G') call note(calibration, records%layout%product// &
            ': its tags say GPS time, a 1A product has those of the on-board computer: they may be tags left in OBC time')
        call to_gps_time(records, clock, extrapolated)
        if (extrapolated > 0) call note(calibration, records%layout%product//': '//integer_text(extrapolated)// &
                                        ' tags are beyond CLK1B, which is extrapolated')
        do i = 1, size(records%warnings)
            call note(calibration, records%layout%product//': '//records%warnings(i)%text)
        end do
    end subroutine read_product

    !> Notes that a product was read, from which files.
    subroutine note_product(calibration, product, paths)
        type(level1_calibration_t), intent(inout) :: calibration
        character(5), intent(in) :: product     !! Its name
        type(string_t), intent(in) :: paths(:)

        type(origin_t) :: origin
        integer :: i

        if (.not. allocated(calibration%products)) allocate (calibration%products(0))
        if (any(calibration%products%name == product)) return
        origin%name = product
        i = findloc(FAMILIES, product(:3), 1)
        if (i > 0) origin%meaning = GIVES(i)
        do i = 1, size(paths)
            if (i > 1) origin%source = trim(origin%source)//', '
            origin%source = trim(origin%source)//' '//name_of(paths(i)%text)
        end do
        origin%source = adjustl(origin%source)
        calibration%products = [calibration%products, origin]
    end subroutine note_product

    !> Which records have none of some bits set in the quality flag.
    pure function without_bits(records, bits) result(good)
        type(level1_records_t), intent(in) :: records
        integer, intent(in) :: bits(:)              !! From 0
        logical :: good(records%count)

        integer :: i, column, flag

        column = records%field_of('qualflg')
        do i = 1, records%count
            flag = nint(records%values(i, column))
            good(i) = .not. any(btest(flag, bits))
        end do
    end function without_bits
end module gracecg_level1_product_reading
