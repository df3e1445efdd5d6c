!> The data of a calibration: in GPS time and SRF, what lies in the spans of the manoeuvre and a little around them; and how
!> products are read from its files.
module gracecg_level1_calibration
    use gracecg_level1_basics
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_header, only: name_of
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_setup, only: level1_setup_t, origin_t
    use gracecg_level1_time, only: level1_clock_t, to_gps_time
    implicit none
    private
    public :: level1_calibration_t, level1_span_t, level1_gyro_t, SPAN_MARGIN, keep_samples, leave_out, note, &
        middle_of, utc_at, name_of_span, field_sigma, signs_are_known, find_files, read_product, note_product, without_bits, &
        no_attitude, check_satellite, NO_CURRENTS

    !> Said where no manoeuvre is found in such files
    character(*), parameter :: NO_CURRENTS = 'all currents of the torque rods are zero (columns torque1A to torque3B): take a '// &
        'file that has them, such as MAG1A, or another release'
    real(dp), parameter :: SPAN_MARGIN = 20     !! Attitude is used so long before and behind a span, s

    type :: level1_gyro_t
        !! Angles of one gyro in a span and its margins
        real(dp), allocatable :: time(:)        !! s from the epoch
        real(dp), allocatable :: angle(:)       !! rad
    end type level1_gyro_t

    type :: level1_span_t
        !! One sub-manoeuvre; times in s from the epoch of the calibration, vectors in SRF
        real(dp) :: start = 0, stop = 0             !! s
        logical :: used = .true.    !! Its samples suffice
        character(80) :: reason = ''                !! Why it is not used
        real(dp), allocatable :: time(:)            !! Of the accelerometer's samples that are left
        real(dp), allocatable :: linear(:, :)       !! m/s^2
        real(dp), allocatable :: angular(:, :)      !! rad/s^2; NaN: none
        real(dp), allocatable :: attitude_time(:)   !! Of the attitude, with margins
        real(dp), allocatable :: quaternion(:, :)   !! Inertial to SRF, scalar last
        real(dp), allocatable :: position(:, :)     !! Inertial, m
        real(dp), allocatable :: angle(:, :)        !! phi, rotation vector summed up, rad
        real(dp), allocatable :: rate(:, :)         !! Angular velocity, rad/s
        real(dp), allocatable :: field(:, :)        !! Of the Earth, T
        real(dp), allocatable :: field_rate(:, :)   !! Its change along the orbit, T/s
        type(level1_gyro_t), allocatable :: gyros(:)    !! Those that there are
        real(dp), allocatable :: firings(:)         !! Times of thruster firings, with margins
        real(dp), allocatable :: shadow_edges(:)    !! Times of the attitude between which the Sun's light changes
        integer :: expected = 0                     !! Samples of the accelerometer
        integer :: samples = 0                      !! That are left
        integer :: flagged = 0                      !! Left out for their quality flags
        integer :: vetoed = 0                       !! For firings
        integer :: outliers = 0                     !! As outliers
        integer :: firings_inside = 0    !! Thruster firings between start and stop
        real(dp) :: mean_field(3) = 0               !! T
    end type level1_span_t

    type :: level1_calibration_t
        !! What a folder says of a calibration manoeuvre
        type(level1_setup_t) :: setup                   !! What the operator says; the mass is that of a product that has it
        type(level1_folder_t) :: files                  !! Of the satellite
        type(level1_clock_t) :: clock                   !! That takes their tags to GPS time
        character(1) :: satellite = ''    !! A to D
        character(10) :: date = ''                      !! Of the epoch, GPS
        integer(i8) :: epoch = 0                        !! s past 2000-01-01 12:00 GPS
        character(24) :: spans_from = ''                !! Where the spans come from
        logical :: all_day = .false.                    !! Rods are driven all the time: spans are cut into arcs of means
        type(level1_span_t), allocatable :: spans(:)    !! The sub-manoeuvres, in time
        integer :: before = 0, parts = 1                !! Spans before these, where they are one of so many parts of the data
        real(dp), allocatable :: current_time(:)        !! s from the epoch
        real(dp), allocatable :: current(:, :)          !! Net current of each rod, mA
        real(dp) :: largest_current = 0                 !! Of all files, mA
        real(dp), allocatable :: measured_field(:, :)   !! T
        real(dp) :: clock_correction = 0                !! GPS less OBC time at the epoch, s
        real(dp) :: field_difference = -1               !! RMS of magnetometer, corrected, less model, T; -1: not known
        real(dp) :: gas(2) = -1                         !! In tanks 1 and 2, kg; -1: not known
        real(dp) :: mass = -1                           !! Of the satellite, kg; -1: no product says it
        type(origin_t), allocatable :: products(:)      !! That were read, with their files
        integer :: follows(3) = 0                       !! Along the orbit the axes follow air and light: 1; -1: with the
                                                        !! opposite sign; 0: the files do not tell
        integer :: order(3) = [1, 2, 3]                 !! Whose linear samples x, y, z seem to be: in that order all axes do
        real(dp) :: light_seen(2, 3) = 0                !! Light as seen by each axis, by what it should be, with sigma
        real(dp) :: orbit_delay = 0                     !! Of the orbit's tags by the magnetometer, s; 0: not significant
        character(256) :: field_turned = ''             !! What the magnetometer says of the attitude, if that is wrong
        real(dp) :: poles_apart = 0                     !! The Earth's by GNV1B with GNI1B, and where it is, rad
        logical :: has_angular = .false.                !! The accelerometer has angular channels
        logical :: zero_angular = .false.               !! It has them, and they are zero: transplanted data (ACT)
        logical :: has_gyros = .false.    !! There are IMU files
        type(string_t), allocatable :: notes(:)         !! What is unusual
    end type level1_calibration_t

    !> What products give, by the letters that they begin with
    character(3), parameter :: FAMILIES(11) = ['ACC', 'MAG', 'SCA', 'QSA', 'IMU', 'GNI', 'GNV', 'THR', 'CLK', 'TIM', 'MAS']
    character(40), parameter :: GIVES(11) = [character(40) :: 'accelerations', 'currents of the rods, measured field', &
        'attitude', 'axes of the star cameras', 'angles of the gyros', 'orbit, inertial', 'orbit, Earth-fixed', &
        'firings of thrusters', 'GPS less receiver time', 'receiver less on-board time', 'masses']

contains

    !> The middle of the manoeuvre, GPS s past 2000-01-01 12:00.
    pure real(dp) function middle_of(calibration) result(time)
        type(level1_calibration_t), intent(in) :: calibration

        time = real(calibration%epoch, dp) + (calibration%spans(1)%start + &
                                              calibration%spans(size(calibration%spans))%stop)/2
    end function middle_of

    !> UTC of a time from the epoch.
    type(utc_t) function utc_at(calibration, time)
        type(level1_calibration_t), intent(in) :: calibration
        real(dp), intent(in) :: time        !! s

        utc_at = utc_of_gps(calibration%epoch + floor(time, i8), time - floor(time))
    end function utc_at

    !> A span as people count, among all where these are a part; with blanks behind it.
    pure function name_of_span(calibration, i) result(name)
        type(level1_calibration_t), intent(in) :: calibration
        integer, intent(in) :: i                    !! Its number here
        character(16) :: name

        name = 'span '//integer_text(calibration%before + i)
    end function name_of_span

    !> The sigma of the field of a place: that of the setup, or less where spans at several places show that the corrected
    !> magnetometer is closer to the model: PLACES and LEAST are fitted to the simulated sets four60 and dirty, where that
    !> difference is 5 nT and the model's field is the true one.
    pure real(dp) function field_sigma(calibration) result(sigma)
        type(level1_calibration_t), intent(in) :: calibration

        integer, parameter :: PLACES = 3
        real(dp), parameter :: LEAST = 10*NANOTESLA     ! What no difference shows: a constant along SRF of that size

        sigma = calibration%setup%field_sigma
        if (calibration%field_difference < 0 .or. count(calibration%spans%used) < PLACES) return
        sigma = min(sigma, max(LEAST, calibration%field_difference))
    end function field_sigma

    !> Whether the operator, or every axis along the orbit, confirms the signs of the accelerometer.
    pure logical function signs_are_known(calibration)
        type(level1_calibration_t), intent(in) :: calibration

        signs_are_known = calibration%setup%signs_known .or. all(calibration%follows == 1)
    end function signs_are_known

    !> Notes something unusual.
    subroutine note(calibration, text)
        type(level1_calibration_t), intent(inout) :: calibration
        character(*), intent(in) :: text    !! What, for people

        call append(calibration%notes, text)
    end subroutine note

    !> Keeps some of the samples of the accelerometer.
    subroutine keep_samples(span, stays)
        type(level1_span_t), intent(inout) :: span
        logical, intent(in) :: stays(:)    !! Which, by sample

        integer, allocatable :: wanted(:)
        integer :: k

        wanted = pack([(k, k=1, size(stays))], stays)
        span%time = span%time(wanted)
        span%linear = span%linear(:, wanted)
        span%angular = span%angular(:, wanted)
    end subroutine keep_samples

    !> Leaves a span out; the first reason stays.
    subroutine leave_out(span, reason)
        type(level1_span_t), intent(inout) :: span
        character(*), intent(in) :: reason      !! Why, for people

        if (span%used) span%reason = reason
        span%used = .false.
    end subroutine leave_out

    !> The files of one of some products, on every day that has one: the first product that is there on as many days as
    !> any of them.
    subroutine find_files(calibration, products, paths)
        type(level1_calibration_t), intent(in) :: calibration
        character(5), intent(in) :: products(:)    !! Names of products, the preferred first
        type(string_t), allocatable, intent(out) :: paths(:)    !! In order of the days; none: there is none

        integer :: i

        i = maxloc([(calibration%files%days_with(products(i)), i=1, size(products))], 1)
        call calibration%files%paths_of(products(i), paths)
    end subroutine find_files

    !> Reads the wanted fields of a product in GPS time.
    subroutine read_product(paths, calibration, fields, records, error, windows)
        type(string_t), intent(in) :: paths(:)
        character(*), intent(in) :: fields(:)               !! Their names
        type(level1_calibration_t), intent(inout) :: calibration
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: windows(:, :)     !! (2, n), s past 2000-01-01 12:00; absent: all

        integer :: extrapolated, i

        call read_level1(paths, records, error, fields, windows)
        if (allocated(error)) return
        call note_product(calibration, records%layout%product, paths)
        if (records%count == 0) return
        call check_satellite(records, calibration%satellite, error)
        if (allocated(error)) return
        if (records%layout%product(5:5) == 'A' .and. records%time_ref == 'G') call note(calibration, records%layout%product// &
            ': its tags say GPS time, a 1A product has those of the on-board computer: they may be tags left in OBC time')
        call to_gps_time(records, calibration%clock, extrapolated)
        if (extrapolated > 0) call note(calibration, records%layout%product//': '//integer_text(extrapolated)// &
                                        ' tags are beyond CLK1B, which is extrapolated')
        do i = 1, size(records%warnings)
            call note(calibration, records%layout%product//': '//records%warnings(i)%text)
        end do
    end subroutine read_product

    !> Fails where records are of another satellite than their files' names say.
    subroutine check_satellite(records, satellite, error)
        type(level1_records_t), intent(in) :: records
        character(1), intent(in) :: satellite               !! That is wanted
        type(error_t), allocatable, intent(out) :: error

        if (records%count > 0 .and. records%satellite /= satellite) &
            call fail(error, records%path//': its records are of satellite '//records%satellite//', not '//satellite)
    end subroutine check_satellite

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

    !> Which records hold no unit quaternion in their first four fields.
    pure function no_attitude(records) result(wrong)
        type(level1_records_t), intent(in) :: records
        logical :: wrong(records%count)

        real(dp), parameter :: TOLERANCE = 0.01_dp      ! Of the length
        integer :: i

        wrong = [(.not. abs(norm2(records%values(i, 1:4)) - 1) < TOLERANCE, i=1, records%count)]
    end function no_attitude
end module gracecg_level1_calibration
