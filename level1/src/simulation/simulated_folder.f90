!> A folder of Level-1 files being written: product after product, record after record. After a failure, which is kept,
!> nothing more is done.
!>
!>     call folder%begin('SCA1B', records, first, last)
!>     call folder%tag(time)                       ! for each record
!>     call folder%put('quatangle', values)
!>     call folder%record()
!>     call folder%finish()
module gracecg_level1_simulated_folder
    use, intrinsic :: iso_fortran_env, only: real32
    use gracecg_level1_basics
    use gracecg_files_csv, only: csv_writer_t, SIDE_ENDING
    use gracecg_files_file, only: remove_file, output_file_t
    use gracecg_files_settings, only: settings_t, FULL_RANGE
    use gracecg_simulation_dynamics, only: OMEGA, ATTITUDE
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, KIND_F4
    use gracecg_level1_setup, only: level1_setup_t, describe_level1
    use gracecg_level1_simulated_truth, only: level1_truth_t, truth_point_t
    use gracecg_level1_simulation_settings, only: describe_level1_simulation
    use gracecg_level1_time, only: gps_day
    use gracecg_level1_writer, only: level1_writer_t
    implicit none
    private
    public :: level1_folder_t, write_events, write_setup, write_truth, SETUP_NAME, TRUTH_TABLE, TRUTH_NAMELIST

    !> The folder, and the file of it that is being written.
    type :: level1_folder_t
        character(:), allocatable :: name   !! Its path
        character(1) :: satellite = ''      !! A, B, C or D
        logical :: grace_fo = .true.        !! Satellite C or D
        logical :: binary = .false.         !! GRACE's binary records, where there are such
        integer(i8) :: epoch = 0            !! GPS s past 2000-01-01 12:00: time 0
        type(string_t), allocatable :: written(:)   !! Names of the files, in their order
        type(error_t), allocatable :: failure       !! The first thing that went wrong
        type(level1_layout_t) :: layout             !! Of the product that is written
        real(dp), allocatable :: values(:)          !! Of its next record, by field
        type(level1_writer_t), private :: writer
    contains
        procedure :: begin          !! The file of a product
        procedure :: tag            !! Time tag of the next record
        procedure :: put            !! Values of the next record
        procedure :: record         !! Writes the record
        procedure :: finish         !! The file is complete
        procedure :: path_of        !! Path of a file
        procedure :: remove         !! Leaves no file
    end type level1_folder_t

    character(*), parameter :: TRUTH_TABLE = 'truth.csv', SOE_NAME = 'SOE.txt'      !! A row a second; the events
    character(*), parameter :: TRUTH_NAMELIST = 'truth.nml'     !! What is true and no estimator reads
    character(*), parameter :: SETUP_NAME = 'setup.nml'         !! Name of the file with what the operator says

contains

    !> Begins the file of a product.
    subroutine begin(self, product, records, first, last)
        class(level1_folder_t), intent(inout) :: self
        character(5), intent(in) :: product    !! Such as ACC1A
        integer, intent(in) :: records    !! How many will follow
        real(dp), intent(in) :: first, last     !! Tags, s from the epoch

        type(level1_header_t) :: header
        character(4) :: ending
        logical :: binary

        if (allocated(self%failure)) return
        call level1_layout(product, self%grace_fo, self%layout, self%failure)
        if (allocated(self%failure)) return
        binary = self%binary .and. self%layout%has_binary
        ending = merge('.txt', '.asc', self%grace_fo)
        if (binary) ending = '.dat'
        header%satellite = self%satellite
        header%records = records
        header%first_time = real(self%epoch, dp) + first
        header%last_time = real(self%epoch, dp) + last
        if (allocated(self%values)) deallocate (self%values)
        allocate (self%values(size(self%layout%fields)), source=0.0_dp)
        if (self%layout%id > 0) self%values(self%layout%id) = iachar(self%satellite)
        if (self%layout%time_ref > 0) self%values(self%layout%time_ref) = iachar(merge('R', 'G', product(5:5) == 'A'))
        associate (name => product//'_'//gps_day(self%epoch)//'_'//self%satellite//'_'//merge('04', '02', self%grace_fo)//ending)
            call self%writer%open(self%path_of(name), self%layout, binary, header, self%failure)
            if (.not. allocated(self%failure)) call append(self%written, name)
        end associate
    end subroutine begin

    !> A time tag as seconds and microseconds; and as it is then.
    subroutine tag(self, time, rounded)
        class(level1_folder_t), intent(inout) :: self
        real(dp), intent(in) :: time                    !! s from the epoch
        real(dp), intent(out), optional :: rounded      !! s from the epoch

        integer(i8) :: ticks

        ticks = nint(time*1e6_dp, i8)
        if (present(rounded)) rounded = real(ticks, dp)/1e6_dp
        if (allocated(self%failure)) return
        self%values(1) = real(self%epoch + floor(real(ticks, dp)/1e6_dp, i8), dp)
        if (self%layout%fraction > 0) self%values(self%layout%fraction) = real(modulo(ticks, 1000000_i8), dp)
    end subroutine tag

    !> Puts values in a row of fields, the first by its name. Of single precision is what binary has so.
    subroutine put(self, name, values)
        class(level1_folder_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the first field
        real(dp), intent(in) :: values(:)       !! In the units of the product

        integer :: first, i

        if (allocated(self%failure)) return
        first = self%layout%field_of(name) - 1
        do i = 1, size(values)
            self%values(first + i) = values(i)
            if (self%layout%fields(first + i)%kind == KIND_F4) self%values(first + i) = real(real(values(i), real32), dp)
        end do
    end subroutine put

    subroutine record(self)
        class(level1_folder_t), intent(inout) :: self

        if (.not. allocated(self%failure)) call self%writer%record(self%values)
    end subroutine record

    subroutine finish(self)
        class(level1_folder_t), intent(inout) :: self

        if (.not. allocated(self%failure)) call self%writer%commit(self%failure)
    end subroutine finish

    pure function path_of(self, name) result(path)
        class(level1_folder_t), intent(in) :: self
        character(*), intent(in) :: name        !! Of the file
        character(len(self%name) + 1 + len(name)) :: path

        path = self%name//'/'//name
    end function path_of

    !> Removes the files that were written.
    subroutine remove(self)
        class(level1_folder_t), intent(inout) :: self

        integer :: i

        do i = 1, size(self%written)
            call remove_file(self%path_of(self%written(i)%text))
        end do
        self%written = self%written(:0)
    end subroutine remove

    !> The sequence of events: CMCAL at each begin and end.
    subroutine write_events(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        type(output_file_t) :: file
        integer :: i

        if (allocated(folder%failure)) return
        call file%open(folder%path_of(SOE_NAME), folder%failure)
        if (allocated(folder%failure)) return
        do i = 1, size(truth%dynamics%spans)
            call file%line(trim(event(truth%dynamics%spans(i)%start))//' CMCAL 1 1 start')
            call file%line(trim(event(truth%dynamics%spans(i)%start + truth%dynamics%spans(i)%duration))//' CMCAL 1 0 stop')
        end do
        call file%line(trim(event(0.0_dp))//' VCM 3 0 0 0 before')
        call append(folder%written, SOE_NAME)
        call file%commit(folder%failure)

    contains

        function event(time) result(text)
            real(dp), intent(in) :: time    !! s from the beginning
            character(40) :: text

            write (text, '(f0.3, 1x, a)') real(folder%epoch, dp) + time, 'GRACE'//folder%satellite
        end function event
    end subroutine write_events

    !> What the operator says: mass, inertia with its error, gains as said.
    subroutine write_setup(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        type(level1_setup_t) :: setup
        type(settings_t) :: settings

        if (allocated(folder%failure)) return
        setup%mass = truth%case%satellite%mass
        setup%inertia = truth%errors%inertia_factor*truth%case%satellite%inertia
        setup%rod_gain = truth%settings%rod_gain
        call settings%comment('What the operator of the simulated satellite says')
        call describe_level1(settings, setup)
        call settings%save(folder%path_of(SETUP_NAME), folder%failure)
        if (.not. allocated(folder%failure)) call append(folder%written, SETUP_NAME)
    end subroutine write_setup

    !> What is true: numbers of the run, and a row a second.
    subroutine write_truth(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        character(*), parameter :: COLUMNS = 'gps_s,q1,q2,q3,q4,wx_rad_s,wy_rad_s,wz_rad_s,wdx_rad_s2,wdy_rad_s2,wdz_rad_s2,'// &
            'bx_tesla,by_tesla,bz_tesla,current_x_ma,current_y_ma,current_z_ma,ax_m_s2,ay_m_s2,az_m_s2'
        type(settings_t) :: settings
        type(csv_writer_t) :: file
        type(truth_point_t) :: point
        integer :: k

        if (allocated(folder%failure)) return
        call settings%comment('The truth of simulated Level-1 files: no estimator reads it')
        call describe_truth(settings, truth)
        call settings%save(folder%path_of(TRUTH_NAMELIST), folder%failure)
        if (allocated(folder%failure)) return
        call append(folder%written, TRUTH_NAMELIST)
        call file%open(folder%path_of(TRUTH_TABLE), COLUMNS, [character(80) :: 'truth of simulated Level-1 files, body '// &
                       'axes SRF; a: at the proof mass', 'case '//truth%case%name], folder%failure)
        if (allocated(folder%failure)) return
        do k = 0, truth%duration - 1
            call truth%at(real(k, dp), point)
            call file%row([real(folder%epoch + k, dp), point%state(ATTITUDE), point%state(OMEGA), point%acceleration, &
                           point%acting%field, point%current, point%sensed])
        end do
        call append(folder%written, TRUTH_TABLE)
        call append(folder%written, TRUTH_TABLE//SIDE_ENDING)
        call file%commit(folder%failure)
    end subroutine write_truth

    !> The numbers of a run, with the settings they were drawn by.
    subroutine describe_truth(settings, truth)
        type(settings_t), intent(inout) :: settings
        type(level1_truth_t), intent(in) :: truth

        type(level1_truth_t) :: copy
        real(dp) :: seed
        integer :: i

        copy = truth
        seed = real(truth%seed, dp)
        call settings%group('truth', 'Of this run; SRF')
        call settings%real_value('seed', seed, -FULL_RANGE, FULL_RANGE, '')
        call settings%integer_value('run', copy%run, 0, huge(copy%run), '')
        call number('offset_mm', copy%case%satellite%offset, 'mm, d: from the centre of mass to the proof mass', MILLIMETRE)
        call number('rod_gain', copy%dynamics%gain, 'A m^2/mA')
        call settings%real_value('inertia_said', copy%errors%inertia_factor, -FULL_RANGE, FULL_RANGE, 'by the true one')
        call number('scale', copy%errors%scale, 'of the accelerometer')
        call number('angular_scale', copy%errors%angular_scale, 'of its angular channels')
        do i = 1, 3
            call number('leakage_rod_'//integer_text(i), copy%errors%leak(:, i), 'm/s^2/mA, x, y, z')
            call number('leakage_rate_rod_'//integer_text(i), copy%errors%leak_rate(:, i), 'm/s^2/(mA/s), x, y, z')
        end do
        call settings%real_value('clock_offset', copy%clock_offset, -FULL_RANGE, FULL_RANGE, 's, GPS less receiver time at '// &
                                 'the beginning')
        call settings%end_group()
        call describe_level1_simulation(settings, copy%settings)

    contains

        subroutine number(key, values, meaning, factor)
            character(*), intent(in) :: key, meaning
            real(dp), intent(inout) :: values(:)
            real(dp), intent(in), optional :: factor

            call settings%real_values(key, values, -FULL_RANGE, FULL_RANGE, meaning, factor)
        end subroutine number
    end subroutine describe_truth
end module gracecg_level1_simulated_folder
