!> Merging the shards of a campaign.
module gracecg_studies_campaign_merge
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: integer_text
    use gracecg_studies_campaign, only: campaign_t, campaign_entry_t, new_campaign, summarise
    implicit none
    private
    public :: merge_campaigns, check_settings

    real(dp), parameter :: AGREEMENT = 1e-6_dp
    !! Relative difference up to which two results of one run agree. On one machine they are equal;
    !! another processor may round otherwise

contains

    !> The union of the runs, in their order, with its statistics. A run that several parts have is
    !> taken from the first of them.
    !>
    !> Fails when seed, number of runs, cases or algorithms of the parts differ, when two parts
    !> contradict each other, or when some entry is left without any run.
    subroutine merge_campaigns(parts, names, whole, missing, error)
        type(campaign_t), intent(in) :: parts(:)    !! At least one
        character(*), intent(in) :: names(:)        !! Of their files, for messages
        type(campaign_t), intent(out) :: whole
        integer, intent(out) :: missing             !! Runs that no part has, over all entries
        type(error_t), allocatable, intent(out) :: error

        integer :: p, a, i

        missing = 0
        associate (first => parts(1))
            do p = 2, size(parts)
                call check_settings(first, parts(p), trim(names(1))//' and '//trim(names(p)), error)
                if (allocated(error)) return
            end do
            whole = new_campaign(first%algorithms, size(first%cases), first%seed, first%runs, 1, 1)
            whole%cases = first%cases
        end associate
        do i = 1, size(whole%cases)
            do a = 1, size(whole%algorithms)
                call merge_entry(parts, names, a, i, whole, error)
                if (allocated(error)) return
                missing = missing + whole%runs - size(whole%entries(a, i)%run)
                call summarise(whole, a, i)
            end do
        end do
    end subroutine merge_campaigns

    !> Fails unless two campaigns have the same seed, runs, cases, settings and algorithms.
    subroutine check_settings(first, other, files, error)
        type(campaign_t), intent(in) :: first, other
        character(*), intent(in) :: files           !! What they are, for messages: 'a.csv and b.csv'
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        if (first%version /= other%version) then
            call fail(error, files//' are of different versions: gracecg '//trim(first%version)//' and '// &
                      trim(other%version)//'; make them with one of them')
        else if (first%seed /= other%seed) then
            call fail(error, files//' have different seeds: '//integer_text(first%seed)//' and '// &
                      integer_text(other%seed))
        else if (first%runs /= other%runs) then
            call fail(error, files//' are of campaigns of '//integer_text(first%runs)//' and '// &
                      integer_text(other%runs)//' runs')
        else if (size(first%cases) /= size(other%cases) .or. &
                 size(first%algorithms) /= size(other%algorithms)) then
            call fail(error, files//' have different cases or algorithms')
        else if (any(first%cases%name /= other%cases%name) .or. &
                 any(first%algorithms /= other%algorithms)) then
            call fail(error, files//' have different cases or algorithms')
        end if
        if (allocated(error)) return
        do i = 1, size(first%cases)
            if (first%cases(i)%checksum == other%cases(i)%checksum .and. &
                all(agree(first%cases(i)%offset, other%cases(i)%offset)) .and. &
                same_predictions(first%entries(:, i), other%entries(:, i))) cycle
            call fail(error, files//' have different settings of the case '//trim(first%cases(i)%name))
            return
        end do
    end subroutine check_settings

    pure logical function same_predictions(first, other)
        type(campaign_entry_t), intent(in) :: first(:), other(:)

        integer :: a

        same_predictions = .true.
        do a = 1, size(first)
            same_predictions = same_predictions .and. all(agree(first(a)%predicted, other(a)%predicted))
        end do
    end function same_predictions

    elemental logical function agree(x, y)
        real(dp), intent(in) :: x, y

        agree = abs(x - y) <= AGREEMENT*max(abs(x), abs(y))
    end function agree

    !> The runs of case i with algorithm a, from all parts.
    subroutine merge_entry(parts, names, a, i, whole, error)
        type(campaign_t), intent(in) :: parts(:)
        character(*), intent(in) :: names(:)
        integer, intent(in) :: a, i
        type(campaign_t), intent(inout) :: whole
        type(error_t), allocatable, intent(out) :: error

        integer, allocatable :: source(:)           ! the part that has the run; 0: none
        real(dp), allocatable :: offset(:, :), normalised(:)
        logical, allocatable :: converged(:)
        integer :: p, k

        allocate (source(whole%runs), source=0)
        allocate (offset(3, whole%runs), converged(whole%runs), normalised(whole%runs))
        do p = 1, size(parts)
            associate (entry => parts(p)%entries(a, i))
                do k = 1, size(entry%run)
                    associate (run => entry%run(k))
                        if (source(run) == 0) then
                            source(run) = p
                            offset(:, run) = entry%offset(:, k)
                            converged(run) = entry%converged(k)
                            normalised(run) = entry%normalised_run(k)
                        else if (.not. all(agree(offset(:, run), entry%offset(:, k))) .or. &
                                 (converged(run) .neqv. entry%converged(k))) then
                            call fail(error, trim(names(source(run)))//' and '//trim(names(p))// &
                                      ' contradict each other: '//trim(whole%cases(i)%name)//', '// &
                                      trim(whole%algorithms(a))//', run '//integer_text(run))
                            return
                        end if
                    end associate
                end do
            end associate
        end do
        if (all(source == 0)) then
            call fail(error, 'no file has a run of '//trim(whole%cases(i)%name)//', '// &
                      trim(whole%algorithms(a)))
            return
        end if
        associate (entry => whole%entries(a, i))
            entry%run = pack([(k, k=1, whole%runs)], source > 0)
            entry%offset = offset(:, entry%run)
            entry%converged = converged(entry%run)
            entry%normalised_run = normalised(entry%run)
            entry%predicted = parts(1)%entries(a, i)%predicted
        end associate
    end subroutine merge_entry
end module gracecg_studies_campaign_merge
