!> A series that Level-1 files share with files of others: orbit, attitude, accelerations, masses, firings, magnetometer; by GPS
!> time, in the units and the order of Level-1's fields.
module gracecg_level1_exchange_series
    use gracecg_level1_basics
    use gracecg_level1_header, only: level1_header_t, product_of_file_name, satellite_of_file_name, name_of
    use gracecg_level1_products, only: level1_layout_t, level1_layout, satellite_of_grace_fo, SATELLITES
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_writer, only: level1_writer_t
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    implicit none
    private
    public :: exchange_series_t, exchange_kind_t, EXCHANGE_KINDS, ORBIT, ATTITUDE, kind_of_product, series_of_level1, &
        write_as_level1, make_room, keep_first

    type :: exchange_kind_t
        !! What a series holds
        character(16) :: name = ''          !! As GROOPS calls it
        integer :: code = 0                 !! Of GROOPS
        character(40) :: products = ''      !! Level-1 products that hold it
        character(160) :: fields = ''       !! Their names; NAME* stands for all that begin so
        integer :: columns = 0              !! How many
    end type exchange_kind_t

    !> Masses in kg, on-times in ms, the field in uT, currents in mA
    type(exchange_kind_t), parameter :: EXCHANGE_KINDS(6) = [ &
        exchange_kind_t('ORBIT', -6, 'GNI1B GNV1B', 'xpos ypos zpos xvel yvel zvel', 6), &
        exchange_kind_t('STARCAMERA', -7, 'SCA1B', 'quatangle quaticoeff quatjcoeff quatkcoeff', 4), &
        exchange_kind_t('ACCELEROMETER', -8, 'ACT1B ACC1B', 'lin_accl_x lin_accl_y lin_accl_z', 3), &
        exchange_kind_t('MASS', -16, 'MAS1B', 'mass_thr mass_tnk', 2), &
        exchange_kind_t('THRUSTER', -17, 'THR1B', 'on_time_*', 14), &
        exchange_kind_t('MAGNETOMETER', -18, 'MAG1B', 'MfvX_RAW MfvY_RAW MfvZ_RAW torque1A torque2A torque3A torque1B torque2B '// &
                        'torque3B MF_BCalX MF_BCalY MF_BCalZ torque_cal', 13)]
    integer, parameter :: ORBIT = 1         !! Position, m, and velocity, m/s, in EXCHANGE_KINDS
    integer, parameter :: ATTITUDE = 2      !! Quaternion from inertial axes to SRF, scalar first: SRF coordinates are
                                            !! `rotation_matrix` of it times inertial ones

    type :: exchange_series_t
        !! The samples
        integer :: kind = 0                         !! Of EXCHANGE_KINDS
        character(1) :: satellite = ''              !! A to D; blank: not said
        character(1) :: axes = 'I'                  !! Of an orbit: I inertial, E Earth-fixed
        integer(i8), allocatable :: seconds(:)      !! Whole seconds past 2000-01-01 12:00 GPS
        real(dp), allocatable :: fraction(:)        !! The rest, s
        real(dp), allocatable :: values(:, :)       !! (column, sample)
        type(string_t), allocatable :: remarks(:)   !! What is to be known
    end type exchange_series_t

contains

    !> The kind of what a product holds; 0: none of others' forms has it.
    pure integer function kind_of_product(product) result(kind)
        character(*), intent(in) :: product     !! 'SCA1B'

        do kind = size(EXCHANGE_KINDS), 1, -1
            if (product /= '' .and. index(EXCHANGE_KINDS(kind)%products, product) > 0) return
        end do
    end function kind_of_product

    !> The columns of a kind in records or a layout with these names of fields.
    function places_of(kind, names) result(places)
        integer, intent(in) :: kind             !! Of EXCHANGE_KINDS
        character(16), intent(in) :: names(:)
        integer, allocatable :: places(:)

        type(string_t), allocatable :: wanted(:)
        integer :: i, k, star

        wanted = split_words(EXCHANGE_KINDS(kind)%fields)
        allocate (places(0))
        do i = 1, size(wanted)
            star = index(wanted(i)%text, '*')
            do k = 1, size(names)
                if (star == 0 .and. names(k) == wanted(i)%text) places = [places, k]
                if (star > 0 .and. index(names(k), wanted(i)%text(:max(1, star - 1))) == 1) places = [places, k]
            end do
        end do
    end function places_of

    !> Room for so many samples.
    subroutine make_room(series, samples)
        type(exchange_series_t), intent(inout) :: series
        integer, intent(in) :: samples      !! How many

        series%seconds = spread(0_i8, 1, samples)
        series%fraction = spread(0.0_dp, 1, samples)
        series%values = spread(spread(0.0_dp, 1, EXCHANGE_KINDS(series%kind)%columns), 2, samples)
    end subroutine make_room

    !> Keeps the first samples. Fails where there is none.
    subroutine keep_first(series, samples, path, error)
        type(exchange_series_t), intent(inout) :: series
        integer, intent(in) :: samples      !! How many
        character(*), intent(in) :: path        !! Of the file, for the message
        type(error_t), allocatable, intent(out) :: error

        if (samples == 0) call fail(error, path//': has no data')
        series%seconds = series%seconds(:samples)
        series%fraction = series%fraction(:samples)
        series%values = series%values(:, :samples)
    end subroutine keep_first

    !> Reads a series from a Level-1 file. Fails when its product has no other form, its tags are not GPS time, its frame is
    !> mixed, or no record has the values.
    subroutine series_of_level1(path, series, error)
        character(*), intent(in) :: path                        !! Of the file
        type(exchange_series_t), intent(out) :: series
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: records
        integer, allocatable :: places(:)
        integer :: n, axes

        call read_level1(path, records, error)
        if (allocated(error)) return
        series%kind = kind_of_product(records%layout%product)
        series%satellite = records%satellite
        if (series%kind == 0) then
            call fail(error, path//': '//records%layout%product//' has no form but those of Level-1; GNI1B, GNV1B, SCA1B, '// &
                      'ACT1B, ACC1B, MAS1B, THR1B and MAG1B have')
            return
        else if (records%time_ref == 'R') then
            call fail(error, path//': its tags are of the on-board computer; other forms have GPS time')
            return
        end if
        n = records%count
        places = places_of(series%kind, records%fields)
        call records%drop(any(ieee_is_nan(records%values(:, places)), 2))
        if (records%count == 0) then
            call fail(error, path//': no record has all of '//trim(EXCHANGE_KINDS(series%kind)%fields))
            return
        end if
        allocate (series%remarks(0))
        series%remarks = [series%remarks, records%warnings]
        if (records%count < n) call append(series%remarks, integer_text(n - records%count)//' records have not all of '// &
                                           trim(EXCHANGE_KINDS(series%kind)%fields)//': they are left out')
        call append(series%remarks, 'flags, formal errors and counts are not kept')
        axes = records%field_of('coord_ref')
        if (axes > 0) then
            series%axes = achar(nint(records%values(1, axes)))
            if (any(abs(records%values(:, axes) - records%values(1, axes)) > 0)) then
                call fail(error, path//': coord_ref is mixed: the orbit is in two frames')
                return
            end if
        end if
        series%seconds = records%seconds
        series%fraction = records%fraction
        series%values = transpose(records%values(:, places))
    end subroutine series_of_level1

    !> Writes a series as a Level-1 text file. Its name says product and satellite. What the series has not is 0; an orbit has no
    !> formal errors (1e33, flag 7). Fails when the name does not fit, or the product's tags cannot hold the times.
    subroutine write_as_level1(series, path, error)
        type(exchange_series_t), intent(in) :: series
        character(*), intent(in) :: path                        !! Of the file to write: ..._C_04.txt
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NO_ERROR = 1e33_dp
        integer, parameter :: NO_ERRORS = int(b'10000000'), MASSES = int(b'00000101')
        type(level1_writer_t) :: writer
        type(level1_layout_t) :: layout
        type(level1_header_t) :: header
        integer, allocatable :: places(:)
        real(dp), allocatable :: values(:)
        integer :: i, n

        call choose_layout(series, path, layout, header%satellite, error)
        if (allocated(error)) return
        n = size(series%seconds)
        if (layout%fraction == 0 .and. any(abs(series%fraction) > 0)) then
            call fail(error, path//': tags of '//layout%product//' are whole seconds, but sample '// &
                      integer_text(findloc(abs(series%fraction) > 0, .true., 1))//' is between them')
            return
        end if
        header%records = n
        header%first_time = real(series%seconds(1), dp) + series%fraction(1)
        header%last_time = real(series%seconds(n), dp) + series%fraction(n)
        call writer%open(path, layout, .false., header, error)
        if (allocated(error)) return
        allocate (values(size(layout%fields)), source=0.0_dp)
        values(layout%id) = iachar(header%satellite)
        if (layout%time_ref > 0) values(layout%time_ref) = iachar('G')
        if (layout%product == 'MAS1B') values(layout%prod_flag) = MASSES
        if (series%kind == ORBIT) then
            values(layout%field_of('coord_ref')) = iachar(series%axes)
            values(layout%qualflg) = NO_ERRORS
            where (index(layout%fields%name, '_err') > 0) values = NO_ERROR
        end if
        places = places_of(series%kind, layout%fields%name)
        do i = 1, n
            values(1) = real(series%seconds(i), dp)
            if (layout%fraction > 0) values(layout%fraction) = anint(series%fraction(i)/layout%fraction_unit)
            values(places) = series%values(:, i)
            call writer%record(values)
        end do
        call writer%commit(error)
    end subroutine write_as_level1

    !> Product and satellite by the name of the file to write.
    subroutine choose_layout(series, path, layout, satellite, error)
        type(exchange_series_t), intent(in) :: series
        character(*), intent(in) :: path
        type(level1_layout_t), intent(out) :: layout
        character(1), intent(out) :: satellite
        type(error_t), allocatable, intent(out) :: error

        character(5) :: product

        product = product_of_file_name(path)
        satellite = satellite_of_file_name(path)
        if (scan(satellite, SATELLITES) == 0 .or. kind_of_product(product) /= series%kind) then
            call fail(error, path//': the name of the file has to say a satellite and a product of the kind of the series, '// &
                      trim(EXCHANGE_KINDS(series%kind)%products)//', as '//EXCHANGE_KINDS(series%kind)%products(:5)// &
                      '_2023-06-01_C_04.txt')
        else if (series%satellite /= '' .and. satellite /= series%satellite) then
            call fail(error, name_of(path)//' says satellite '//satellite//', the series is of '//series%satellite)
        else if (series%kind == ORBIT .and. (product == 'GNI1B' .neqv. series%axes == 'I')) then
            call fail(error, name_of(path)//': the orbit is '//trim(merge('inertial   ', 'Earth-fixed', series%axes == 'I'))// &
                      ': that is '//merge('GNI1B', 'GNV1B', series%axes == 'I'))
        else
            call level1_layout(product, satellite_of_grace_fo(satellite), layout, error)
        end if
    end subroutine choose_layout
end module gracecg_level1_exchange_series
